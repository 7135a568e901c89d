#pragma once

#include <raybundle/solver/init/image_pairs.h>
#include <raybundle/solver/init/initialize.h>
#include <raybundle/solver/init/relative_pose.h>
#include <raybundle/solver/init/resection.h>
#include <raybundle/solver/init/restriction.h>
#include <raybundle/solver/init/triangulation.h>

#include <cstdint>
#include <vector>

namespace raybundle::init {

struct IncrementalOptions {
  PairOptions pairs = {};
  RelativePoseOptions relative_pose = {};
  ResectionOptions resection = {};
  TriangulationOptions triangulation = {};
  double seed_parallax = 0.05;  ///< radians: a seed pair with less counts in proportion
  /// Images are added together that see at least this share of the points that the best one sees.
  double batch_share = 0.75;
  int bundle_iterations = 20;  ///< of each bundle adjustment but the last
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: all cores
};

struct IncrementalReport {
  Conclusion conclusion;
  std::vector<std::uint8_t> images, points, observations;  ///< 1: placed, used
  std::int64_t placed_images = 0, placed_points = 0;
  int bundle_adjustments = 0, failed_adjustments = 0;
  std::int64_t resections = 0;
  double pair_seconds = 0, bundle_seconds = 0, seconds = 0;
};

/// The rival of global initialisation: a seed pair of many points and good parallax, then images
/// one batch after the other by what they see of the points so far, new points, and a bundle
/// adjustment after each batch [Snavely06], lenses fixed, with Cauchy's loss. A seed without enough
/// points of parallax is given up for the next one. What could not be placed stays as it was.
/// Throws as initialize() does, and concludes likewise.
IncrementalReport reconstruct_incrementally(Problem& problem,
                                            const IncrementalOptions& options = {},
                                            const Progress& progress = {});

/// What was placed as a problem of its own.
Restriction placed_part(const Problem& problem, const IncrementalReport& report);

}  // namespace raybundle::init
