#include <raybundle/linalg/hub_clusters.h>

#include <algorithm>

namespace raybundle::linalg {
namespace {

constexpr std::int32_t none = -1;

// Calls visit(other) for every coupling of a hub and every hub of its leaf.
template <class Visit>
void for_neighbours(const BlockLayout& layout, std::int64_t hub, Visit&& visit) {
  const Incidence& hubs = layout.hub_side;
  const Incidence& leaves = layout.leaf_side;
  for (std::int64_t p = hubs.begin[index(hub)]; p < hubs.begin[index(hub + 1)]; ++p) {
    const std::int32_t leaf = leaves.block[index(hubs.list[index(p)])];
    for (std::int64_t c = leaves.begin[index(leaf)]; c < leaves.begin[index(leaf + 1)]; ++c) {
      visit(hubs.block[index(c)]);
    }
  }
}

bool has_leaves(const BlockLayout& layout, std::int64_t hub) {
  return layout.hub_side.begin[index(hub)] < layout.hub_side.begin[index(hub + 1)];
}

// Counts what is shared, and forgets it again in time proportional to what was counted.
class Tally {
 public:
  explicit Tally(std::int64_t size) : shared_(index(size), 0) {}

  void add(std::int32_t i) {
    if (shared_[index(i)]++ == 0) counted_.push_back(i);
  }
  void clear() {
    for (const std::int32_t i : counted_) shared_[index(i)] = 0;
    counted_.clear();
  }
  /// The one with the most by its weight, of equals the first, among those that qualify; or none.
  template <class Qualifies, class Weight>
  std::int32_t most(Qualifies&& qualifies, Weight&& weight) const {
    std::int32_t best = none;
    for (const std::int32_t i : counted_) {
      if (!qualifies(i)) continue;
      const std::int64_t ahead =
          best == none ? 1 : shared_[index(i)] * weight(best) - shared_[index(best)] * weight(i);
      if (ahead > 0 || (ahead == 0 && i < best)) best = i;
    }
    return best;
  }

 private:
  std::vector<std::int64_t> shared_;
  std::vector<std::int32_t> counted_;
};

// Grows clusters until every hub with leaves is in one; returns their hubs.
std::vector<std::vector<std::int32_t>> grow(const BlockLayout& layout, std::int64_t size,
                                            std::vector<std::int32_t>& of_hub) {
  std::vector<std::vector<std::int32_t>> clusters;
  Tally shared(layout.hubs);
  std::int64_t first_free = 0;
  const auto is_free = [&](std::int32_t h) { return of_hub[index(h)] == none; };
  const auto couplings = [&](std::int32_t h) {
    return layout.hub_side.begin[index(h) + 1] - layout.hub_side.begin[index(h)];
  };
  std::int32_t seed = none;
  while (true) {
    for (; first_free < layout.hubs; ++first_free) {
      if (is_free(static_cast<std::int32_t>(first_free)) && has_leaves(layout, first_free)) break;
    }
    if (first_free == layout.hubs) return clusters;
    if (seed == none) seed = static_cast<std::int32_t>(first_free);
    const auto cluster = static_cast<std::int32_t>(clusters.size());
    clusters.emplace_back();
    shared.clear();
    while (seed != none && static_cast<std::int64_t>(clusters.back().size()) < size) {
      of_hub[index(seed)] = cluster;
      clusters.back().push_back(seed);
      for_neighbours(layout, seed, [&](std::int32_t other) {
        if (is_free(other)) shared.add(other);
      });
      seed = shared.most(is_free, couplings);
    }
  }
}

// Clusters of less than half the size join a neighbour; empty ones stay behind.
void join_fragments(const BlockLayout& layout, std::int64_t size,
                    std::vector<std::vector<std::int32_t>>& clusters,
                    std::vector<std::int32_t>& of_hub) {
  Tally shared(static_cast<std::int64_t>(clusters.size()));
  for (std::size_t g = 0; g < clusters.size(); ++g) {
    if (2 * static_cast<std::int64_t>(clusters[g].size()) >= size) continue;
    shared.clear();
    for (const std::int32_t hub : clusters[g]) {
      for_neighbours(layout, hub, [&](std::int32_t other) { shared.add(of_hub[index(other)]); });
    }
    const std::int32_t to =
        shared.most([&](std::int32_t i) { return index(i) != g; }, [](std::int32_t) { return 1; });
    if (to == none) continue;
    for (const std::int32_t hub : clusters[g]) {
      of_hub[index(hub)] = to;
      clusters[index(to)].push_back(hub);
    }
    clusters[g].clear();
  }
}

}  // namespace

HubClusters cluster_hubs(const BlockLayout& layout, std::int64_t size) {
  HubClusters result;
  result.of_hub.assign(index(layout.hubs), none);
  auto clusters = grow(layout, size, result.of_hub);
  join_fragments(layout, size, clusters, result.of_hub);
  std::fill(result.of_hub.begin(), result.of_hub.end(), 0);
  for (const auto& hubs : clusters) {
    if (hubs.empty()) continue;
    for (const std::int32_t hub : hubs) {
      result.of_hub[index(hub)] = static_cast<std::int32_t>(result.count);
    }
    ++result.count;
  }
  result.count = std::max<std::int64_t>(result.count, layout.hubs > 0 ? 1 : 0);
  return result;
}

}  // namespace raybundle::linalg
