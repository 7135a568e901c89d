#pragma once

#include <raybundle/solver/init/ray_pairs.h>

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

/// Motions that explain pairs of rays without depth: epipolar geometry then says less than usual.
namespace raybundle::init {

/// The rotation that turns most rays a of `which` into their b: sum of Cauchy's loss of the
/// distances, scale in pixels, by reweighting [Wahba65].
Eigen::Matrix3d pure_rotation(const RayPairs& pairs, std::span<const std::int32_t> which,
                              double scale);

/// The homography that does, b ~ H a; likewise.
Eigen::Matrix3d homography(const RayPairs& pairs, std::span<const std::int32_t> which,
                           double scale);

/// Squared distance of b from H a, in the pixels of both.
double squared_error(const Eigen::Matrix3d& H, const RayPair& pair);

/// How many of `which` are within so many pixels of H a.
std::int64_t explained(const Eigen::Matrix3d& H, const RayPairs& pairs,
                       std::span<const std::int32_t> which, double pixels);

/// The poses that move a plane as H does, up to the sign of t: two of different rotation, or one
/// [Ma04, 5.3]. None where H is a rotation.
std::vector<RelativePose> poses_of_plane(const Eigen::Matrix3d& H);

}  // namespace raybundle::init
