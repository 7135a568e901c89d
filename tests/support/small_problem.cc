#include <raybundle/tests/support/small_problem.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <raybundle/models/random.h>
#include <raybundle/models/rotation.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

namespace raybundle::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double camera_distance = 5;
constexpr double far_distance = 1e8;
const Vector3d cap_axis(0, 0, 1);

Vector3d normal_vector(Random& random, double deviation) {
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return deviation * Vector3d(x, y, z);
}

template <class T>
void shuffle(std::vector<T>& values, Random& random) {
  for (std::size_t i = values.size(); i > 1; --i) {
    std::swap(values[i - 1],
              values[static_cast<std::size_t>(random.below(static_cast<std::int64_t>(i)))]);
  }
}

/// A camera within 45 degrees or so of the cap's axis that looks at the origin.
void append_camera(Random& random, std::vector<double>& cameras) {
  const Vector3d tilt = normal_vector(random, 0.4);
  const Vector3d centre = camera_distance * (cap_axis + tilt).normalized();
  Eigen::Matrix3d R_wc;  // columns: the camera's axes; it looks down -z, that is from centre to 0
  R_wc.col(2) = centre.normalized();
  R_wc.col(0) = R_wc.col(2).unitOrthogonal();
  R_wc.col(1) = R_wc.col(2).cross(R_wc.col(0));
  const Eigen::Matrix3d R_cw =
      so3::exp(Vector3d(0, 0, random.uniform(-3.14, 3.14))) * R_wc.transpose();
  const Vector3d phi = so3::log(R_cw);
  const Vector3d t_cw = -R_cw * centre;
  const double f = random.uniform(450, 550);
  const double k1 = random.uniform(-0.05, 0.05);
  const double k2 = random.uniform(-0.01, 0.01);
  cameras.insert(cameras.end(), {phi.x(), phi.y(), phi.z(), t_cw.x(), t_cw.y(), t_cw.z()});
  cameras.insert(cameras.end(), {f, k1, k2});
}

/// The lens of BAL, spelled out once more so that the fixture does not rest on what it tests.
Vector2d project(const double* camera, const Vector3d& X) {
  const Vector3d phi(camera[0], camera[1], camera[2]);
  const Vector3d X_c = so3::exp(phi) * X + Vector3d(camera[3], camera[4], camera[5]);
  const Vector2d p = -X_c.head<2>() / X_c.z();
  const double p2 = p.squaredNorm();
  return camera[6] * (1 + camera[7] * p2 + camera[8] * p2 * p2) * p;
}

using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;  // (point, camera)

Pairs visibility(const SmallProblemOptions& options, Random& random) {
  const int observed_cameras = options.cameras - options.unobserved_cameras;
  const int observed_points = options.points - options.unobserved_points;
  std::vector<std::int32_t> order(static_cast<std::size_t>(observed_cameras));
  std::iota(order.begin(), order.end(), 0);
  Pairs pairs;
  for (int i = 0; i < observed_points; ++i) {
    const int wanted = i < options.points_seen_once ? 1 : options.observations_per_point;
    shuffle(order, random);
    for (int k = 0; k < std::min(wanted, observed_cameras); ++k) {
      pairs.emplace_back(i, order[static_cast<std::size_t>(k)]);
    }
  }
  const std::int64_t distinct = static_cast<std::int64_t>(pairs.size());
  for (int k = 0; k < options.duplicate_observations; ++k) {
    pairs.push_back(pairs[static_cast<std::size_t>(random.below(distinct))]);
  }
  std::sort(pairs.begin(), pairs.end());
  if (options.shuffled) shuffle(pairs, random);
  return pairs;
}

void observe(Problem& problem, const Pairs& pairs, double pixel_noise, Random& random) {
  for (const auto& [point, camera] : pairs) {
    const double* X = &problem.points[static_cast<std::size_t>(3 * point)];
    const Vector2d u =
        project(&problem.cameras[static_cast<std::size_t>(9 * camera)], Vector3d(X[0], X[1], X[2]));
    problem.observation_camera.push_back(camera);
    problem.observation_point.push_back(point);
    problem.observations.push_back(u.x() + pixel_noise * random.normal());
    problem.observations.push_back(u.y() + pixel_noise * random.normal());
  }
}

void perturb(Problem& problem, double noise, Random& random) {
  for (std::size_t j = 0; j < problem.cameras.size(); j += 9) {
    for (std::size_t k = 0; k < 6; ++k) problem.cameras[j + k] += noise * random.normal();
  }
  for (double& x : problem.points) x += noise * random.normal();
}

}  // namespace

Problem small_problem(const SmallProblemOptions& options) {
  const int special = options.points_seen_once + options.far_points + options.unobserved_points;
  if (options.cameras <= options.unobserved_cameras || options.points < special) {
    throw std::invalid_argument("small_problem: the counts do not fit together");
  }
  Random random(options.seed);
  Problem problem;
  for (int j = 0; j < options.cameras; ++j) append_camera(random, problem.cameras);
  for (int i = 0; i < options.points; ++i) {
    const int far_index = i - options.points_seen_once;
    const bool far = far_index >= 0 && far_index < options.far_points;
    Vector3d X = normal_vector(random, 0.5);
    if (far) X = far_distance * (0.1 * X - cap_axis);
    problem.points.insert(problem.points.end(), {X.x(), X.y(), X.z()});
  }
  observe(problem, visibility(options, random), options.pixel_noise, random);
  perturb(problem, options.parameter_noise, random);
  return problem;
}

}  // namespace raybundle::test
