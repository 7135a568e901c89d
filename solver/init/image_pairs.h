#pragma once

#include <raybundle/solver/init/sightings.h>

#include <cstdint>
#include <vector>

namespace raybundle::init {

/// Two images, i < j, and how many points both saw.
struct ImagePair {
  std::int32_t i, j;
  std::int64_t common;
};

struct PairOptions {
  std::int64_t min_common = 20;
  /// Of each image the pairs with most points in common; a pair that either image wants stays.
  std::int64_t most_per_image = 40;
};

/// Ascending by i, then j. Beyond what images want there are the pairs of two spanning forests
/// without a common edge, of most points in common: what all pairs connect stays connected, and
/// where it can be by more than one of them.
std::vector<ImagePair> image_pairs(const Sightings& sightings, const PairOptions& options,
                                   linalg::ThreadPool& pool);

}  // namespace raybundle::init
