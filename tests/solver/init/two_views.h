#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Geometry>

#include <raybundle/models/random.h>
#include <raybundle/models/rotation.h>
#include <raybundle/solver/init/ray_pairs.h>

/// Two images of a few points, with known pose between them.
namespace raybundle::test {

inline Eigen::Vector3d random_vector(Random& random) {
  return {random.normal(), random.normal(), random.normal()};
}

inline Eigen::Matrix3d random_rotation(Random& random, double angle) {
  return so3::exp(Eigen::Vector3d(angle * random_vector(random).normalized()));
}

enum class Shape { cloud, plane, far };

struct TwoImages {
  init::RayPairs pairs;
  init::RelativePose pose;
  std::vector<bool> wrong;  // of a pair
};

struct TwoImagesOptions {
  std::uint64_t seed = 1;
  std::int64_t points = 100;
  Shape shape = Shape::cloud;
  double noise = 0;        // pixels, at 1000 a radian
  double wrong_share = 0;  // of the pairs
  double baseline = 1;     // of points some 4 to 8 away
};

/// Of points in front of both cameras, which look down -z.
inline TwoImages two_images(const TwoImagesOptions& options) {
  constexpr double pixels = 1000;
  Random random(options.seed, 77);
  TwoImages result;
  result.pose.R = random_rotation(random, 0.3);
  result.pose.t = random_vector(random).normalized();
  const auto n = options.points;
  result.pairs = {Eigen::Matrix3Xd(3, n), Eigen::Matrix3Xd(3, n),
                  Eigen::VectorXd::Constant(n, pixels), Eigen::VectorXd::Constant(n, pixels)};
  const auto noisy = [&](const Eigen::Vector3d& ray) {
    return (ray.normalized() + options.noise / pixels * random_vector(random)).normalized();
  };
  for (std::int64_t i = 0; i < n;) {
    Eigen::Vector3d X(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-8, -4));
    if (options.shape == Shape::plane) X[2] = -6 + 0.3 * X[0] - 0.2 * X[1];
    if (options.shape == Shape::far) X *= 1e7;
    const Eigen::Vector3d Y = result.pose.R * X + options.baseline * result.pose.t;
    if (Y[2] > -0.5) continue;
    result.pairs.a.col(i) = noisy(X);
    const bool wrong = random.uniform() < options.wrong_share;
    const Eigen::Vector3d elsewhere(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), -1);
    result.pairs.b.col(i) = noisy(wrong ? elsewhere : Y);
    result.wrong.push_back(wrong);
    ++i;
  }
  return result;
}

inline double angle_between(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  return so3::log(Eigen::Matrix3d(A.transpose() * B)).norm();
}

}  // namespace raybundle::test
