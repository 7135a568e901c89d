#pragma once

#include <raybundle/solver/init/ray_pairs.h>

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>

namespace raybundle::init {

/// [t]_x R.
Eigen::Matrix3d essential_matrix(const RelativePose& pose);

/// The four poses that have this essential matrix, or its negative [HartleyZisserman04, 9.6.2].
std::array<RelativePose, 4> poses_of(const Eigen::Matrix3d& E);

/// Squared distance, in pixels, of a pair of rays from the nearest pair that meets in a point, to
/// first order [Sampson82]; each ray's own pixels.
double squared_epipolar_error(const Eigen::Matrix3d& E, const RayPairs& pairs, std::int64_t i);

/// In front of, behind and too far from both cameras to tell: pairs.
struct Sides {
  std::int64_t front = 0, behind = 0;
};
/// Of those of `which`. A point is far where its two rays differ from parallel ones by less than
/// `least_parallax` pixels.
Sides sides(const RelativePose& pose, const RayPairs& pairs, std::span<const std::int32_t> which,
            double least_parallax);

/// That one of the four which has most points in front.
RelativePose facing_pose(const Eigen::Matrix3d& E, const RayPairs& pairs,
                         std::span<const std::int32_t> which, double least_parallax);

/// The pose with the least sum of Cauchy's loss of the epipolar errors of `which`, scale in pixels,
/// from a pose nearby; a few steps of Gauss and Newton, damped.
RelativePose refined_pose(const RelativePose& start, const RayPairs& pairs,
                          std::span<const std::int32_t> which, double scale);

}  // namespace raybundle::init
