// A street for a forward-looking camera: two rows of house fronts along a winding path and, for a
// share of the points, features far ahead.
//
// World frame: x right, y up, the street runs towards -z. Lengths are in steps between cameras.

#include <raybundle/models/scenes/street.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <raybundle/models/error.h>
#include <raybundle/models/scenes/camera.h>
#include <raybundle/models/scenes/track_lengths.h>

namespace raybundle::scenes {
namespace {

constexpr double image_width = 1280;  // pixels
constexpr double image_height = 960;
constexpr double nominal_focal_length = 1000;
constexpr double street_half_width = 6;
constexpr double nearest_depth = 2;
constexpr double bend_length = 40;   // steps over which the street turns to one side
constexpr double bend_angle = 0.15;  // radians the heading swings to either side
constexpr double longest_front_depth = 60;
constexpr double longest_far_depth = 800;
constexpr std::int64_t longest_front_track = 20;     // longer ones are planned for far features
constexpr std::int64_t longest_planned_track = 150;  // bends end them
constexpr std::int64_t corner_length = 20;           // steps, for a right angle
constexpr std::int64_t shortest_lap = 4 * (corner_length + 20);
constexpr double revisit_share = 0.2;
constexpr int patience = 40;
constexpr double least_parallax = 0.026;  // radians, between rays to a house front

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
  const std::int64_t straight = side - corner_length;
  double angle = 0.5 * pi * static_cast<double>(turns);
  if (along < straight) {
    angle += swing(static_cast<double>(along), 0.5 * static_cast<double>(straight));
  } else {
    const double share = static_cast<double>(along - straight) / corner_length;
    angle += 0.5 * pi * share - bend_angle;
  }
  return angle > pi ? angle - 2 * pi : angle;
}

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

Pixel see(const Camera& camera, const Vec3& X) {
  return project(camera, rotate(camera.phi, difference(X, camera.centre)));
}

struct Feature {
  Vec3 X;
  double reach = 0;        // largest depth at which it is recognised
  std::int64_t limit = 0;  // longest track
};

/// A feature ahead of a camera, in that camera's frame: on a house front or far away. One whose
/// track is to be long is far away, and the farther ahead the longer that is.
Feature feature_ahead(const Camera& camera, double far_share, std::int64_t planned,
                      Random& random) {
  Feature feature;
  Vec3 X_c;
  const double tail = 1 / std::sqrt(1 - random.uniform());  // Pareto: P(tail > x) = 1 / x^2
  if (random.uniform() < far_share || planned > longest_front_track) {
    const double width = planned > longest_front_track
                             ? 0.6 * longest_front_track / static_cast<double>(planned)
                             : 0.6;
    X_c.z = -random.uniform(0.25, 1) * longest_far_depth;
    X_c.x = random.uniform(-width, width) * X_c.z;
    X_c.y = random.uniform(-0.05, 0.3) * -X_c.z;
    feature.reach = 2 * longest_far_depth;
    feature.limit = 2 + static_cast<std::int64_t>(6 * tail);
  } else {
    const double side = random.uniform() < 0.5 ? -1 : 1;
    const double relief = 0.2 * random.normal();  // window sills, doors
    X_c.z = -random.uniform(8, 35);
    X_c.x = side * (street_half_width + relief);
    X_c.y = random.uniform(-1.5, 8);
    feature.reach = longest_front_depth;
    feature.limit = 1 + static_cast<std::int64_t>(3 * tail);
  }
  if (planned > 0) feature.limit = 2 * planned + 2;  // not all who could see a feature find it
  const Vec3 away = {-camera.phi.x, -camera.phi.y, -camera.phi.z};
  feature.X = sum(camera.centre, rotate(away, X_c));
  return feature;
}

bool sees(const Camera& camera, const Feature& feature) {
  const Pixel u = see(camera, feature.X);
  return u.depth >= nearest_depth && u.depth <= feature.reach && u.x >= -0.5 * image_width &&
         u.x <= 0.5 * image_width && u.y >= -0.5 * image_height && u.y <= 0.5 * image_height;
}

/// Cameras that see a feature, in the order in which a track takes them up.
using Track = std::vector<std::int64_t>;

/// A track grows at these: forward and backward from a camera, on each visit of the place.
struct Front {
  std::int64_t next;
  int step;
};

std::vector<Front> fronts_at(std::int64_t anchor, std::int64_t count, std::int64_t lap,
                             Random& random) {
  std::vector<Front> fronts = {{anchor + 1, 1}, {anchor - 1, -1}};
  if (lap == 0) return fronts;
  for (std::int64_t j = anchor % lap; j < count; j += lap) {
    if (j == anchor) continue;
    fronts.push_back({j, 1});
    fronts.push_back({j - 1, -1});
  }
  // Some features are rather found again on another visit than in the next image.
  if (random.uniform() < revisit_share) std::reverse(fronts.begin(), fronts.end());
  return fronts;
}

Track track(const std::vector<Camera>& cameras, const Feature& feature, std::int64_t anchor,
            std::vector<Front> fronts) {
  const auto count = static_cast<std::int64_t>(cameras.size());
  const auto seen_by = [&](std::int64_t j) {
    return j >= 0 && j < count && sees(cameras[static_cast<std::size_t>(j)], feature);
  };
  Track seen;
  if (!seen_by(anchor)) return seen;
  seen.push_back(anchor);
  while (!fronts.empty()) {
    for (auto front = fronts.begin(); front != fronts.end();) {
      if (static_cast<std::int64_t>(seen.size()) >= feature.limit) return seen;
      if (seen_by(front->next)) {
        seen.push_back(front->next);
        front->next += front->step;
        ++front;
      } else {
        front = fronts.erase(front);
      }
    }
  }
  return seen;
}

/// Puts the camera whose ray to X is farthest from the first one's in second place. Returns the
/// sine of that angle.
double widen(Track& track, const std::vector<Camera>& cameras, const Vec3& X) {
  const auto ray = [&](std::int64_t j) {
    const Vec3 d = difference(X, cameras[static_cast<std::size_t>(j)].centre);
    return scaled(1 / norm(d), d);
  };
  const Vec3 first = ray(track[0]);
  double most = -1;
  for (std::size_t k = 1; k < track.size(); ++k) {
    const double angle = norm(cross(first, ray(track[k])));
    if (angle <= most) continue;
    most = angle;
    std::swap(track[1], track[k]);
  }
  return most;
}

/// The scene, and of each point the camera it was drawn for.
class Street {
 public:
  explicit Street(const StreetOptions& options)
      : options_(options),
        plan_random_(options.seed, 3),
        plan_(options.points, options.observations,
              std::min(options.cameras, longest_planned_track), plan_random_) {}

  /// Draws features ahead of a camera until at least two cameras see one (about every second does),
  /// or as many as planned; after many attempts it is the feature seen by the most.
  void draw(std::int64_t point, const std::vector<Camera>& cameras, Random& random) {
    const std::int64_t anchor = anchor_of(point);
    const Camera& camera = cameras[static_cast<std::size_t>(anchor)];
    const std::int64_t planned = plan_.exists() ? plan_.wanted(point) : 0;
    const auto enough = static_cast<std::size_t>(std::max<std::int64_t>(2, planned));
    track_.clear();
    for (int attempt = 0; track_.size() < enough; ++attempt) {
      if (attempt >= patience && track_.size() >= 2) break;
      if (attempt >= hopeless) fail_to_see("street scene");
      const Feature feature = feature_ahead(camera, options_.far_share, planned, random);
      Track found = track(cameras, feature, anchor,
                          fronts_at(anchor, options_.cameras, options_.lap, random));
      if (found.size() < std::max<std::size_t>(2, track_.size() + 1)) continue;
      // Plans copy real problems, whose makers had left out most points of little parallax.
      if (plan_.exists() && widen(found, cameras, feature.X) < least_parallax &&
          feature.reach == longest_front_depth && attempt < patience) {
        continue;
      }
      X_ = feature.X;
      track_ = std::move(found);
    }
    if (plan_.exists()) {
      const auto available = static_cast<std::int64_t>(track_.size());
      thin(static_cast<std::size_t>(plan_.settle(point, available, plan_random_)));
    }
    std::sort(track_.begin(), track_.end());
  }

  std::int64_t anchor_of(std::int64_t point) const { return point % options_.cameras; }
  const Vec3& X() const { return X_; }               ///< of the point drawn last
  const Track& observers() const { return track_; }  ///< ascending

 private:
  /// Keeps the anchor, the camera with the most parallax to it, and others at random.
  void thin(std::size_t length) {
    for (std::size_t k = 2; k < length; ++k) {
      const auto rest = static_cast<std::int64_t>(track_.size() - k);
      std::swap(track_[k], track_[k + static_cast<std::size_t>(plan_random_.below(rest))]);
    }
    track_.resize(length);
  }

  StreetOptions options_;
  Random plan_random_;
  TrackPlan plan_;
  Vec3 X_;
  Track track_;
};

void check(const StreetOptions& options) {
  check_count("street scene", options.cameras, 2, "cameras");
  check_count("street scene", options.points, 1, "points");
  check_observations("street scene", options.observations, options.cameras, options.points);
  check_range("street scene", options.far_share, 0, 1, "far share");
  const bool good = options.lap == 0 || (options.lap >= shortest_lap && options.lap % 4 == 0);
  if (good) return;
  throw InputError("street scene", 0, "a lap of " + std::to_string(options.lap) + " steps",
                   "0 or a multiple of 4 of at least " + std::to_string(shortest_lap));
}

/// Errors of deviation 1, drawn in between so that street() has the numbers it always had.
struct Errors {
  std::vector<Vec3> rotations, centres, points;
  std::vector<double> pixels;
};

struct Drawn {
  Scene scene;
  std::vector<Camera> cameras;
  Errors errors;
};

Drawn draw(const StreetOptions& options) {
  check(options);
  Random camera_random(options.seed, 1), feature_random(options.seed, 2);
  Drawn drawn = {{{}, image_width, image_height}, drive(options, camera_random), {}};
  Problem& truth = drawn.scene.truth;
  Errors& errors = drawn.errors;
  for (const Camera& camera : drawn.cameras) {
    append_camera(truth, camera);
    errors.rotations.push_back(normal_vector(camera_random, 1));
    errors.centres.push_back(normal_vector(camera_random, 1));
  }
  Street street(options);
  for (std::int64_t i = 0; i < options.points; ++i) {
    street.draw(i, drawn.cameras, feature_random);
    append_point(truth, street.X());
    errors.points.push_back(normal_vector(feature_random, 1));
    for (const std::int64_t j : street.observers()) {
      append_observation(truth, j, see(drawn.cameras[static_cast<std::size_t>(j)], street.X()));
      errors.pixels.push_back(feature_random.normal());
      errors.pixels.push_back(feature_random.normal());
    }
  }
  return drawn;
}

}  // namespace

Scene street_scene(const StreetOptions& options) { return draw(options).scene; }

Problem street(const StreetOptions& options) {
  constexpr double rotation_error = 0.005, centre_error = 0.1, point_error = 0.01;
  constexpr double pixel_error = 0.5;
  const Drawn drawn = draw(options);
  const Errors& errors = drawn.errors;
  Problem start = drawn.scene.truth;
  start.cameras.clear();
  start.points.clear();
  for (std::size_t j = 0; j < drawn.cameras.size(); ++j) {
    Camera camera = {{}, {}, nominal_focal_length, 0, 0};
    camera.phi = sum(drawn.cameras[j].phi, scaled(rotation_error, errors.rotations[j]));
    camera.centre = sum(drawn.cameras[j].centre, scaled(centre_error, errors.centres[j]));
    append_camera(start, camera);
  }
  for (std::size_t i = 0; i < errors.points.size(); ++i) {
    const Vec3 X = point_of(drawn.scene.truth, static_cast<std::int64_t>(i));
    const double deviation = point_error * see(drawn.cameras[i % drawn.cameras.size()], X).depth;
    append_point(start, sum(X, scaled(deviation, errors.points[i])));
  }
  for (std::size_t k = 0; k < errors.pixels.size(); ++k) {
    start.observations[k] += pixel_error * errors.pixels[k];
  }
  return start;
}

}  // namespace raybundle::scenes
