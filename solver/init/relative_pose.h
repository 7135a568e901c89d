#pragma once

#include <raybundle/models/random.h>
#include <raybundle/solver/init/ransac.h>
#include <raybundle/solver/init/ray_pairs.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace raybundle::init {

struct RelativePoseOptions {
  double threshold = 4;           ///< pixels: the largest epipolar error of an inlier
  std::int64_t min_inliers = 15;  ///< else the pair has no pose; 6 at least
  /// Of the inliers, so many explained by a simpler model make the pair degenerate.
  double degenerate_share = 0.9;
  RansacOptions ransac = {};
};

/// What a pair of images tells about its relative pose:
///   general   rotation and direction of translation
///   planar    the same, from points of a plane; where either of the two poses that a plane allows
///             may be right, t = 0 and there is another R
///   rotation  the rotation alone: hardly a point has moved by parallax; t = 0
enum class PairKind { general, planar, rotation };
const char* name(PairKind value);

struct TwoView {
  RelativePose pose;
  PairKind kind = PairKind::general;
  std::optional<Eigen::Matrix3d> R_other;  ///< that may be the right one as well
  std::vector<std::int32_t> inliers;       ///< pairs, ascending
  double parallax = 0;                     ///< median angle between the rays of inliers, radians
  int iterations = 0;                      ///< of RANSAC
};

/// From five-point samples [Nister04] in RANSAC, refined on the inliers. Empty where there are too
/// few of them. The same for the same pairs, options and state of `random`.
std::optional<TwoView> relative_pose(const RayPairs& pairs, const RelativePoseOptions& options,
                                     Random& random);

}  // namespace raybundle::init
