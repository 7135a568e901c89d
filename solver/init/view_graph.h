#pragma once

#include <raybundle/solver/init/conclusion.h>
#include <raybundle/solver/init/image_pairs.h>
#include <raybundle/solver/init/relative_pose.h>
#include <raybundle/solver/init/sightings.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace raybundle::init {

/// Two images of which the relative pose is known: X_j = R X_i + t.
struct ViewEdge {
  std::int32_t i = 0, j = 0;
  RelativePose pose;
  RelativePose alone;  ///< as the pair tells it by itself; `pose` may have averaged rotations
  PairKind kind = PairKind::general;
  std::optional<Eigen::Matrix3d> R_other;  ///< TwoView::R_other
  std::int64_t common = 0;                 ///< points that both saw
  std::int64_t inliers = 0;                ///< of these, points that fit an epipolar geometry
  double parallax = 0;                     ///< median of the inliers, radians
};

/// The epipolar geometries of a set of images [Liu18, 3.1].
struct ViewGraph {
  std::int64_t images = 0;
  std::vector<ViewEdge> edges;  ///< ascending by i, then j
  bool stopped = false;         ///< progress said so: pairs are missing
};

/// The relative poses of these pairs; those that have none are left out. Every pair has random
/// numbers of its own from the seed, so that threads do not change the result.
ViewGraph view_graph(const Sightings& sightings, std::span<const ImagePair> pairs,
                     const RelativePoseOptions& options, std::uint64_t seed,
                     linalg::ThreadPool& pool, const Progress& progress = {});

}  // namespace raybundle::init
