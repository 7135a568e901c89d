#pragma once

#include <Eigen/Core>

#include <cstdint>

namespace raybundle::init {

/// What two images saw of a point: unit rays in the frames of their cameras, and how many pixels a
/// radian is there.
struct RayPair {
  Eigen::Vector3d a, b;
  double pixels_a, pixels_b;
};

/// The same of many points, in columns.
struct RayPairs {
  Eigen::Matrix3Xd a, b;
  Eigen::VectorXd pixels_a, pixels_b;

  std::int64_t size() const { return a.cols(); }
  RayPair pair(std::int64_t i) const { return {a.col(i), b.col(i), pixels_a[i], pixels_b[i]}; }
};

/// X_b = R X_a + t, with |t| = 1, or 0 where nothing tells it.
struct RelativePose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
};

}  // namespace raybundle::init
