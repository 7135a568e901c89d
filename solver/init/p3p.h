#pragma once

#include <Eigen/Core>

#include <vector>

namespace raybundle::init {

/// X_c = R_cw X + t_cw.
struct CameraPose {
  Eigen::Matrix3d R_cw = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_cw = Eigen::Vector3d::Zero();

  Eigen::Vector3d centre() const { return -(R_cw.transpose() * t_cw); }
};

/// The poses, up to four, from which three points (columns, in the world) are seen along three unit
/// rays (columns, in the camera's frame), in front: Grunert's quartic for the ratio of two
/// distances [Haralick94, 2.1]. None where points are on a line.
std::vector<CameraPose> poses_of_three(const Eigen::Matrix3d& X, const Eigen::Matrix3d& rays);

}  // namespace raybundle::init
