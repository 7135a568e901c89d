#include <raybundle/solver/init/image_pairs.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/solver/init/graph.h>

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

namespace raybundle::init {
namespace {

// All pairs of image i, those with most points in common first.
std::vector<ImagePair> pairs_of(const Sightings& sightings, std::int32_t i, std::int64_t min_common,
                                std::vector<std::int64_t>& common) {
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
    if (count >= min_common) result.push_back({std::min(i, j), std::max(i, j), count});
  }
  std::sort(result.begin(), result.end(), [](const ImagePair& x, const ImagePair& y) {
    return std::tuple(-x.common, x.i, x.j) < std::tuple(-y.common, y.i, y.j);
  });
  return result;
}

struct Found {
  std::vector<ImagePair> wanted, others;  // that one image asks for; that it does not, once
};

Found wanted_by(std::int32_t i, std::vector<ImagePair> pairs, std::int64_t most) {
  Found found;
  const auto last = pairs.begin() + std::min(static_cast<std::ptrdiff_t>(pairs.size()),
                                             static_cast<std::ptrdiff_t>(most));
  found.wanted.assign(pairs.begin(), last);
  std::copy_if(last, pairs.end(), std::back_inserter(found.others),
               [i](const ImagePair& pair) { return pair.i == i; });
  return found;
}

void sort_once(std::vector<ImagePair>& pairs) {
  const auto key = [](const ImagePair& pair) { return std::pair(pair.i, pair.j); };
  std::sort(pairs.begin(), pairs.end(),
            [&](const ImagePair& x, const ImagePair& y) { return key(x) < key(y); });
  pairs.erase(std::unique(pairs.begin(), pairs.end(),
                          [&](const ImagePair& x, const ImagePair& y) { return key(x) == key(y); }),
              pairs.end());
}

// Of all pairs.
std::vector<ImagePair> two_forests(std::int64_t images, std::vector<ImagePair> pairs) {
  std::vector<ImagePair> result;
  for (int k = 0; k < 2; ++k) {
    std::vector<WeightedEdge> edges;
    edges.reserve(pairs.size());
    for (const ImagePair& pair : pairs) {
      edges.push_back({pair.i, pair.j, static_cast<double>(pair.common)});
    }
    for (const std::int64_t at : maximum_spanning_forest(images, edges)) {
      result.push_back(pairs[linalg::index(at)]);
      pairs[linalg::index(at)].common = 0;
    }
    std::erase_if(pairs, [](const ImagePair& pair) { return pair.common == 0; });
  }
  return result;
}

}  // namespace

std::vector<ImagePair> image_pairs(const Sightings& sightings, const PairOptions& options,
                                   linalg::ThreadPool& pool) {
  const linalg::Chunks pieces = linalg::chunks(sightings.images(), 4);
  std::vector<Found> found(linalg::index(pieces.pieces));
  pool.run(pieces.pieces, [&](std::int64_t piece) {
    std::vector<std::int64_t> common(linalg::index(sightings.images()), 0);
    Found& mine = found[linalg::index(piece)];
    for (std::int64_t k = pieces.begin(piece); k < pieces.end(piece); ++k) {
      const auto i = static_cast<std::int32_t>(k);
      const Found of_i =
          wanted_by(i, pairs_of(sightings, i, options.min_common, common), options.most_per_image);
      mine.wanted.insert(mine.wanted.end(), of_i.wanted.begin(), of_i.wanted.end());
      mine.others.insert(mine.others.end(), of_i.others.begin(), of_i.others.end());
    }
  });
  std::vector<ImagePair> result, all;
  for (const Found& mine : found) {
    result.insert(result.end(), mine.wanted.begin(), mine.wanted.end());
    all.insert(all.end(), mine.others.begin(), mine.others.end());
  }
  if (!all.empty()) {
    all.insert(all.end(), result.begin(), result.end());
    sort_once(all);
    const auto forests = two_forests(sightings.images(), std::move(all));
    result.insert(result.end(), forests.begin(), forests.end());
  }
  sort_once(result);
  return result;
}

}  // namespace raybundle::init
