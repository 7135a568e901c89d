#include <raybundle/solver/init/image_pairs.h>

#include <raybundle/linalg/block_layout.h>

#include <algorithm>
#include <tuple>
#include <utility>

namespace raybundle::init {
namespace {

// The pairs that image i wants, its own number first.
std::vector<ImagePair> wanted(const Sightings& sightings, std::int32_t i,
                              const PairOptions& options, std::vector<std::int64_t>& common) {
  std::vector<std::int32_t> others;
  for (const std::int32_t s : sightings.of_image(i)) {
    const Sightings::Range track = sightings.of_point(sightings.point(s));
    for (std::int64_t t = track.first; t < track.last; ++t) {
      const std::int32_t j = sightings.image(t);
      if (j != i && common[linalg::index(j)]++ == 0) others.push_back(j);
    }
  }
  std::vector<ImagePair> result;
  for (const std::int32_t j : others) {
    const std::int64_t count = std::exchange(common[linalg::index(j)], 0);
    if (count >= options.min_common) result.push_back({std::min(i, j), std::max(i, j), count});
  }
  std::sort(result.begin(), result.end(), [](const ImagePair& x, const ImagePair& y) {
    return std::tuple(-x.common, x.i, x.j) < std::tuple(-y.common, y.i, y.j);
  });
  if (static_cast<std::int64_t>(result.size()) > options.most_per_image) {
    result.resize(linalg::index(options.most_per_image));
  }
  return result;
}

}  // namespace

std::vector<ImagePair> image_pairs(const Sightings& sightings, const PairOptions& options,
                                   linalg::ThreadPool& pool) {
  const linalg::Chunks pieces = linalg::chunks(sightings.images(), 4);
  std::vector<std::vector<ImagePair>> found(linalg::index(pieces.pieces));
  pool.run(pieces.pieces, [&](std::int64_t piece) {
    std::vector<std::int64_t> common(linalg::index(sightings.images()), 0);
    std::vector<ImagePair>& mine = found[linalg::index(piece)];
    for (std::int64_t i = pieces.begin(piece); i < pieces.end(piece); ++i) {
      const auto pairs = wanted(sightings, static_cast<std::int32_t>(i), options, common);
      mine.insert(mine.end(), pairs.begin(), pairs.end());
    }
  });
  std::vector<ImagePair> result;
  for (const auto& mine : found) result.insert(result.end(), mine.begin(), mine.end());
  const auto key = [](const ImagePair& pair) { return std::pair(pair.i, pair.j); };
  std::sort(result.begin(), result.end(),
            [&](const ImagePair& x, const ImagePair& y) { return key(x) < key(y); });
  result.erase(
      std::unique(result.begin(), result.end(),
                  [&](const ImagePair& x, const ImagePair& y) { return key(x) == key(y); }),
      result.end());
  return result;
}

}  // namespace raybundle::init
