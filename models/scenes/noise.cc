#include <raybundle/models/scenes/noise.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <raybundle/models/scenes/camera.h>

namespace raybundle::scenes {
namespace {

constexpr double largest = std::numeric_limits<double>::max();

/// Streams of the generator: of their own, so that the noise has nothing to do with the scene.
enum Stream : std::uint64_t { pixel_stream = 101, outlier_stream, camera_stream, point_stream };

/// `count` indices below `size`, ascending, every such set equally likely (selection sampling).
std::vector<std::int64_t> choose(std::int64_t count, std::int64_t size, Random& random) {
  std::vector<std::int64_t> chosen;
  chosen.reserve(static_cast<std::size_t>(count));
  for (std::int64_t k = 0; k < size && count > 0; ++k) {
    if (random.below(size - k) >= count) continue;
    chosen.push_back(k);
    --count;
  }
  return chosen;
}

struct Depths {
  std::vector<double> camera;  // 1 / root mean square of 1 / depth of what it sees, or 1
  std::vector<double> point;   // in the nearest camera
};

Depths depths(const Problem& truth) {
  const auto cameras = static_cast<std::size_t>(truth.camera_count());
  std::vector<Mat3> R_cw(cameras);
  for (std::size_t j = 0; j < cameras; ++j) {
    const double* c = truth.cameras.data() + j * Problem::camera_size;
    R_cw[j] = rotation_matrix({c[0], c[1], c[2]});
  }
  std::vector<double> squares(cameras, 0), counts(cameras, 0);
  Depths result;
  result.point.assign(static_cast<std::size_t>(truth.point_count()), largest);
  for (std::size_t k = 0; k < truth.observation_camera.size(); ++k) {
    const auto j = static_cast<std::size_t>(truth.observation_camera[k]);
    const auto i = static_cast<std::size_t>(truth.observation_point[k]);
    const double t_z = truth.cameras[j * Problem::camera_size + 5];
    const double z = dot(R_cw[j].z, point_of(truth, static_cast<std::int64_t>(i))) + t_z;
    const double depth = z < 0 ? -z : z;
    squares[j] += 1 / (depth * depth);
    counts[j] += 1;
    result.point[i] = std::min(result.point[i], depth);
  }
  for (double& depth : result.point) {
    if (depth == largest) depth = 0;  // nobody sees it: it stays
  }
  result.camera.assign(cameras, 1);
  for (std::size_t j = 0; j < cameras; ++j) {
    if (counts[j] > 0) result.camera[j] = std::sqrt(counts[j] / squares[j]);
  }
  return result;
}

void check(const StartOptions& options) {
  check_range("start", options.rotation, 0, largest, "rotation noise");
  check_range("start", options.position, 0, largest, "position noise");
  check_range("start", options.focal, 0, 0.25, "focal noise");  // f stays positive
  check_range("start", options.point, 0, largest, "point noise");
}

}  // namespace

NoisyProblem add_noise(const Scene& scene, const NoiseOptions& options) {
  check_range("noise", options.pixel_noise, 0, largest, "pixel noise");
  check_range("noise", options.outlier_share, 0, 1, "outlier share");
  NoisyProblem result = {scene.truth, {}};
  std::vector<double>& observations = result.problem.observations;
  Random random(options.seed, pixel_stream);
  for (double& u : observations) u += options.pixel_noise * random.normal();

  const std::int64_t count = scene.truth.observation_count();
  const std::int64_t outliers = std::llround(options.outlier_share * static_cast<double>(count));
  Random outlier_random(options.seed, outlier_stream);
  result.outliers = choose(std::min(outliers, count), count, outlier_random);
  for (const std::int64_t k : result.outliers) {
    double* u = observations.data() + 2 * k;
    u[0] = outlier_random.uniform(-0.5, 0.5) * scene.image_width;
    u[1] = outlier_random.uniform(-0.5, 0.5) * scene.image_height;
  }
  return result;
}

Problem perturb(const Problem& truth, const StartOptions& options) {
  check(options);
  const Depths depth = depths(truth);
  Problem start = truth;
  start.cameras.clear();
  start.points.clear();
  Random camera_random(options.seed, camera_stream), point_random(options.seed, point_stream);
  for (std::int64_t j = 0; j < truth.camera_count(); ++j) {
    Camera camera = camera_of(truth, j);
    const double deviation = options.position * depth.camera[static_cast<std::size_t>(j)];
    camera.phi = sum(camera.phi, normal_vector(camera_random, options.rotation));
    camera.centre = sum(camera.centre, normal_vector(camera_random, deviation));
    // Cut at three deviations: a focal length may not get near zero.
    camera.f *= 1 + options.focal * std::clamp(camera_random.normal(), -3.0, 3.0);
    if (!options.distortion) camera.k1 = camera.k2 = 0;
    append_camera(start, camera);
  }
  start.points.reserve(truth.points.size());
  for (std::int64_t i = 0; i < truth.point_count(); ++i) {
    const double deviation = options.point * depth.point[static_cast<std::size_t>(i)];
    append_point(start, sum(point_of(truth, i), normal_vector(point_random, deviation)));
  }
  return start;
}

}  // namespace raybundle::scenes
