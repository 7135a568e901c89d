#include <raybundle/models/scenes/street_drive.h>

namespace raybundle::scenes {
namespace {

constexpr double bend_length = 40;   // steps over which the street turns to one side
constexpr double bend_angle = 0.15;  // radians the heading swings to either side

/// How the street swings from side to side: a triangle wave that rises for `length` steps.
double swing(double phase, double length) {
  const double ramp = phase < length ? phase : 2 * length - phase;
  return bend_angle * (2 * ramp / length - 1);
}

/// Heading of the street (radians, positive to the left) after `step` steps.
double heading(std::int64_t step) {
  const std::int64_t phase = step % (2 * static_cast<std::int64_t>(bend_length));
  return swing(static_cast<double>(phase), bend_length);
}

/// The same round a block of four sides. Each is the one before, turned by a right angle, so that
/// the way ends where it began.
double heading(std::int64_t step, std::int64_t lap) {
  const std::int64_t side = lap / 4;
  const std::int64_t turns = step / side % 4;
  const std::int64_t along = step % side;
  const std::int64_t straight = side - street_corner_length;
  double angle = 0.5 * pi * static_cast<double>(turns);
  if (along < straight) {
    angle += swing(static_cast<double>(along), 0.5 * static_cast<double>(straight));
  } else {
    const double share = static_cast<double>(along - straight) / street_corner_length;
    angle += 0.5 * pi * share - bend_angle;
  }
  return angle > pi ? angle - 2 * pi : angle;
}

}  // namespace

std::vector<Camera> drive(const StreetOptions& options, Random& random) {
  std::vector<Camera> cameras(static_cast<std::size_t>(options.cameras));
  Vec3 path;
  std::int64_t step = 0;
  for (Camera& camera : cameras) {
    if (options.lap > 0 && step % options.lap == 0) path = {};
    const double yaw = options.lap > 0 ? heading(step, options.lap) : heading(step);
    ++step;
    path.x -= sine(yaw);
    path.z -= cosine(yaw);
    camera.centre = sum(path, normal_vector(random, 0.03));
    camera.phi = normal_vector(random, 0.02);  // looks about a little
    camera.phi.y -= yaw;                       // R_cw undoes the heading
    camera.f = nominal_focal_length + 5 * random.normal();
    camera.k1 = -0.02 + 0.002 * random.normal();
    camera.k2 = 0.005 + 0.001 * random.normal();
  }
  return cameras;
}

}  // namespace raybundle::scenes
