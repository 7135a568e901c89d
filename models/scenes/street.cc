// A street for a forward-looking camera: two rows of house fronts along a winding path and, one
// point in ten, features far ahead. Built with -ffp-contract=off, and from + - * / and sqrt alone
// (no C library functions, no Eigen), so that the same options give the same bits everywhere.
//
// World frame: x right, y up, the street runs towards -z. Lengths are in steps between cameras.

#include <raybundle/models/scenes/street.h>

#include <cmath>
#include <limits>
#include <string>

#include <raybundle/models/error.h>
#include <raybundle/models/scenes/random.h>

namespace raybundle::scenes {
namespace {

constexpr double half_image_width = 640;   // pixels
constexpr double half_image_height = 480;  // pixels
constexpr double nominal_focal_length = 1000;
constexpr double street_half_width = 6;
constexpr double nearest_depth = 2;
constexpr double far_share = 0.1;
constexpr double bend_length = 40;   // steps over which the street turns to one side
constexpr double bend_angle = 0.15;  // radians the heading swings to either side
constexpr double longest_front_depth = 60;
constexpr double longest_far_depth = 800;

struct Vec3 {
  double x = 0, y = 0, z = 0;
};

struct Camera {
  Vec3 phi;     // rotation vector of R_cw
  Vec3 centre;  // in the world
  double f = nominal_focal_length, k1 = 0, k2 = 0;
};

struct Pixel {
  double x = 0, y = 0, depth = 0;
};

/// sum_k (-x2)^k / (first (first + 1) ... (first + 2k)) scaled so that the first term is 1: with
/// first = 2 this is sin(x)/x, with first = 3 it is 2 (1 - cos x)/x^2. For |x| < 1.
double alternating_series(double x2, int first) {
  double sum = 0;
  for (int k = 10; k >= 1; --k) {
    const int d = first + 2 * (k - 1);
    sum = x2 / (d * (d + 1)) * (1 - sum);
  }
  return 1 - sum;
}

double sine(double x) { return x * alternating_series(x * x, 2); }
double cosine(double x) { return 1 - 0.5 * x * x * alternating_series(x * x, 3); }

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// exp(phi) v by Rodrigues' formula [Qu18, Eq. 2.6], for |phi| < 1.
Vec3 rotate(const Vec3& phi, const Vec3& v) {
  const double angle2 = phi.x * phi.x + phi.y * phi.y + phi.z * phi.z;
  const double a = alternating_series(angle2, 2);
  const double b = 0.5 * alternating_series(angle2, 3);
  const Vec3 c = cross(phi, v);
  const Vec3 d = cross(phi, c);
  return {v.x + a * c.x + b * d.x, v.y + a * c.y + b * d.y, v.z + a * c.z + b * d.z};
}

Vec3 normal_vector(Random& random, double deviation) {
  Vec3 v;
  v.x = deviation * random.normal();
  v.y = deviation * random.normal();
  v.z = deviation * random.normal();
  return v;
}

Vec3 sum(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec3 difference(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

/// Heading of the street (radians, positive to the left) after `step` steps: a triangle wave.
double heading(std::int64_t step) {
  const double phase = static_cast<double>(step % (2 * static_cast<std::int64_t>(bend_length)));
  const double ramp = phase < bend_length ? phase : 2 * bend_length - phase;
  return bend_angle * (2 * ramp / bend_length - 1);
}

std::vector<Camera> drive(std::int64_t count, Random& random) {
  std::vector<Camera> cameras(static_cast<std::size_t>(count));
  Vec3 path;
  std::int64_t step = 0;
  for (Camera& camera : cameras) {
    const double yaw = heading(step++);
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

/// The lens of BAL: p = -X_c.xy / X_c.z, u = f (1 + k1 |p|^2 + k2 |p|^4) p.
Pixel project(const Camera& camera, const Vec3& X) {
  const Vec3 X_c = rotate(camera.phi, difference(X, camera.centre));
  const double x = -X_c.x / X_c.z;
  const double y = -X_c.y / X_c.z;
  const double p2 = x * x + y * y;
  const double scale = camera.f * (1 + camera.k1 * p2 + camera.k2 * p2 * p2);
  return {scale * x, scale * y, -X_c.z};
}

struct Feature {
  Vec3 X;
  double reach = 0;        // largest depth at which it is recognised
  std::int64_t limit = 0;  // longest track
};

/// A feature ahead of a camera, in that camera's frame: on a house front or far away.
Feature feature_ahead(const Camera& camera, Random& random) {
  Feature feature;
  Vec3 X_c;
  const double tail = 1 / std::sqrt(1 - random.uniform());  // Pareto: P(tail > x) = 1 / x^2
  if (random.uniform() < far_share) {
    X_c.z = -random.uniform(0.25, 1) * longest_far_depth;
    X_c.x = random.uniform(-0.6, 0.6) * X_c.z;
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
  const Vec3 away = {-camera.phi.x, -camera.phi.y, -camera.phi.z};
  feature.X = sum(camera.centre, rotate(away, X_c));
  return feature;
}

bool sees(const Camera& camera, const Feature& feature) {
  const Pixel u = project(camera, feature.X);
  return u.depth >= nearest_depth && u.depth <= feature.reach && u.x >= -half_image_width &&
         u.x <= half_image_width && u.y >= -half_image_height && u.y <= half_image_height;
}

struct Track {
  std::int64_t first = 0, last = 0;  // cameras, last included
};

/// The run of cameras around `anchor` that see the feature, grown on both sides up to its limit.
Track track(const std::vector<Camera>& cameras, const Feature& feature, std::int64_t anchor) {
  const auto seen_by = [&](std::int64_t j) {
    return j >= 0 && j < static_cast<std::int64_t>(cameras.size()) &&
           sees(cameras[static_cast<std::size_t>(j)], feature);
  };
  Track run = {anchor, anchor};
  if (!seen_by(anchor)) return run;
  bool forward = true, backward = true;
  while ((forward || backward) && run.last - run.first + 1 < feature.limit) {
    if (forward) forward = seen_by(run.last + 1);
    if (forward) ++run.last;
    if (run.last - run.first + 1 >= feature.limit) break;
    if (backward) backward = seen_by(run.first - 1);
    if (backward) --run.first;
  }
  return run;
}

void append_camera(Problem& problem, const Camera& camera) {
  const Vec3 t = rotate(camera.phi, camera.centre);
  problem.cameras.insert(problem.cameras.end(), {camera.phi.x, camera.phi.y, camera.phi.z});
  problem.cameras.insert(problem.cameras.end(), {-t.x, -t.y, -t.z});
  problem.cameras.insert(problem.cameras.end(), {camera.f, camera.k1, camera.k2});
}

void append_point(Problem& problem, const Vec3& X) {
  problem.points.insert(problem.points.end(), {X.x, X.y, X.z});
}

void append_observation(Problem& problem, std::int64_t camera, std::int64_t point, double x,
                        double y) {
  problem.observation_camera.push_back(static_cast<std::int32_t>(camera));
  problem.observation_point.push_back(static_cast<std::int32_t>(point));
  problem.observations.insert(problem.observations.end(), {x, y});
}

/// Draws features ahead of a camera until at least two cameras see one (about every second does).
void append_feature(StreetScene& scene, const std::vector<Camera>& cameras, std::int64_t point,
                    const StreetOptions& options, Random& random) {
  const std::int64_t anchor = point % static_cast<std::int64_t>(cameras.size());
  const Camera& camera = cameras[static_cast<std::size_t>(anchor)];
  Feature feature;
  Track run;
  do {
    feature = feature_ahead(camera, random);
    run = track(cameras, feature, anchor);
  } while (run.last == run.first);

  append_point(scene.truth, feature.X);
  const double deviation = options.point_noise * project(camera, feature.X).depth;
  append_point(scene.start, sum(feature.X, normal_vector(random, deviation)));
  for (std::int64_t j = run.first; j <= run.last; ++j) {
    const Pixel u = project(cameras[static_cast<std::size_t>(j)], feature.X);
    const double x = u.x + options.pixel_noise * random.normal();
    const double y = u.y + options.pixel_noise * random.normal();
    append_observation(scene.truth, j, point, x, y);
  }
}

void check_count(std::int64_t value, std::int64_t least, const std::string& what) {
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  if (value >= least && value <= most) return;
  throw InputError("street scene", 0, std::to_string(value) + " " + what,
                   std::to_string(least) + " to " + std::to_string(most));
}

void check_noise(double value, const std::string& what) {
  if (value >= 0 && value <= std::numeric_limits<double>::max()) return;
  throw InputError("street scene", 0, what + " of " + std::to_string(value),
                   "a number that is finite and not negative");
}

void check(const StreetOptions& options) {
  check_count(options.cameras, 2, "cameras");
  check_count(options.points, 1, "points");
  check_noise(options.pixel_noise, "pixel noise");
  check_noise(options.rotation_noise, "rotation noise");
  check_noise(options.position_noise, "position noise");
  check_noise(options.point_noise, "point noise");
}

}  // namespace

StreetScene street_scene(const StreetOptions& options) {
  check(options);
  Random camera_random(options.seed, 1), feature_random(options.seed, 2);
  StreetScene scene;
  const std::vector<Camera> cameras = drive(options.cameras, camera_random);
  for (const Camera& camera : cameras) {
    append_camera(scene.truth, camera);
    Camera start;  // its lens is the nominal one
    start.phi = sum(camera.phi, normal_vector(camera_random, options.rotation_noise));
    start.centre = sum(camera.centre, normal_vector(camera_random, options.position_noise));
    append_camera(scene.start, start);
  }
  for (std::int64_t i = 0; i < options.points; ++i) {
    append_feature(scene, cameras, i, options, feature_random);
  }
  scene.start.observation_camera = scene.truth.observation_camera;
  scene.start.observation_point = scene.truth.observation_point;
  scene.start.observations = scene.truth.observations;
  return scene;
}

Problem street(const StreetOptions& options) { return street_scene(options).start; }

}  // namespace raybundle::scenes
