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

/// How far a pair of rays is from one that meets in a point, to first order [Sampson82].
struct EpipolarError {
  double e;         ///< b^T E a
  double variance;  ///< the square of e that a pixel is worth, each ray's own pixels

  /// Pixels; 0 where no pair of rays there can miss, infinite where it is not a number.
  double squared() const;
};
EpipolarError epipolar_error(const Eigen::Matrix3d& E, const RayPair& pair);
double squared_epipolar_error(const Eigen::Matrix3d& E, const RayPairs& pairs, std::int64_t i);

/// Where the point of a pair of rays is: in front of both cameras, behind one, or too far to tell:
/// its two rays differ from parallel ones by less than `least_parallax` pixels.
enum class Side { front, behind, far };
Side side_of(const RelativePose& pose, const RayPair& pair, double least_parallax);

struct Sides {
  std::int64_t front = 0, behind = 0;
};
/// How many of `which` are where.
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
