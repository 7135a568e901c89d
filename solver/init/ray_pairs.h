#pragma once

#include <Eigen/Core>

#include <cstdint>

namespace raybundle::init {

/// What two images saw of the same points: unit rays in the frames of their cameras, in columns,
/// and how many pixels a radian is there.
struct RayPairs {
  Eigen::Matrix3Xd a, b;
  Eigen::VectorXd pixels_a, pixels_b;

  std::int64_t size() const { return a.cols(); }
};

/// X_b = R X_a + t, with |t| = 1, or 0 where nothing tells it.
struct RelativePose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
};

}  // namespace raybundle::init
