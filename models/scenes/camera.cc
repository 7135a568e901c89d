#include <raybundle/models/scenes/camera.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <limits>
#include <string>

#include <raybundle/models/error.h>

namespace raybundle::scenes {
namespace {

/// The shortest decimals that read back to it: 1e-06, not 0.000001.
std::string shortest(double value) {
  std::array<char, 32> buffer;
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr};
}

}  // namespace

Pixel project(const Camera& camera, const Vec3& X_c) {
  const double x = -X_c.x / X_c.z;
  const double y = -X_c.y / X_c.z;
  const double p2 = x * x + y * y;
  const double scale = camera.f * (1 + camera.k1 * p2 + camera.k2 * p2 * p2);
  return {scale * x, scale * y, -X_c.z};
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

void append_observation(Problem& problem, std::int64_t camera, const Pixel& u) {
  append_observation(problem, camera, problem.point_count() - 1, u.x, u.y);
}

void append_track(Problem& problem, const Vec3& X, Sightings sightings) {
  std::sort(sightings.begin(), sightings.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  append_point(problem, X);
  for (const auto& [camera, u] : sightings) append_observation(problem, camera, u);
}

Camera camera_of(const Problem& problem, std::int64_t index) {
  const double* c = problem.cameras.data() + index * Problem::camera_size;
  Camera camera;
  camera.phi = {c[0], c[1], c[2]};
  camera.centre = rotate({-c[0], -c[1], -c[2]}, {-c[3], -c[4], -c[5]});
  camera.f = c[6];
  camera.k1 = c[7];
  camera.k2 = c[8];
  return camera;
}

Vec3 point_of(const Problem& problem, std::int64_t index) {
  const double* X = problem.points.data() + index * Problem::point_size;
  return {X[0], X[1], X[2]};
}

void check_count(const std::string& source, std::int64_t value, std::int64_t least,
                 const std::string& what) {
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  if (value >= least && value <= most) return;
  throw InputError(source, 0, std::to_string(value) + " " + what,
                   std::to_string(least) + " to " + std::to_string(most));
}

void check_range(const std::string& source, double value, double least, double most,
                 const std::string& what) {
  if (value >= least && value <= most) return;
  const bool bounded = most < std::numeric_limits<double>::max();
  throw InputError(source, 0, what + " of " + shortest(value),
                   bounded ? shortest(least) + " to " + shortest(most)
                           : "a finite number of at least " + shortest(least));
}

void fail_to_see(const std::string& source) {
  throw InputError(source, 0, "cameras that have no points in common",
                   "more cameras, closer to each other, or another seed");
}

void check_observations(const std::string& source, std::int64_t observations, std::int64_t cameras,
                        std::int64_t points) {
  if (observations == 0) return;
  if (observations >= 2 * points && observations <= cameras * points) return;
  throw InputError(source, 0, std::to_string(observations) + " observations",
                   "two per point (" + std::to_string(2 * points) + ") to one per camera and " +
                       "point (" + std::to_string(cameras * points) + "), or 0 for what the " +
                       "geometry gives");
}

}  // namespace raybundle::scenes
