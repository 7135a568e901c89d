#include <raybundle/linalg/hub_clusters.h>

#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/reduced_pattern.h>

#include <algorithm>
#include <numeric>
#include <string>

namespace raybundle::linalg {
namespace {

constexpr std::int32_t none = -1;

// Counts what is shared, and forgets it again in time proportional to what was counted.
class Tally {
 public:
  explicit Tally(std::int64_t size) : shared_(index(size), 0) {}

  void add(std::int32_t i, std::int64_t number = 1) {
    if (shared_[index(i)] == 0) counted_.push_back(i);
    shared_[index(i)] += number;
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

  const std::vector<std::int32_t>& counted() const { return counted_; }
  std::int64_t shared(std::int32_t i) const { return shared_[index(i)]; }

 private:
  std::vector<std::int64_t> shared_;
  std::vector<std::int32_t> counted_;
};

// Grows clusters until every hub with leaves is in one; returns their hubs.
std::vector<std::vector<std::int32_t>> grow(const HubGraph& graph, std::int64_t size,
                                            std::vector<std::int32_t>& of_hub) {
  std::vector<std::vector<std::int32_t>> clusters;
  Tally shared(graph.hubs());
  std::int64_t first_free = 0;
  const auto is_free = [&](std::int32_t h) { return of_hub[index(h)] == none; };
  const auto couplings = [&](std::int32_t h) { return graph.couplings[index(h)]; };
  std::int32_t seed = none;
  while (true) {
    for (; first_free < graph.hubs(); ++first_free) {
      const auto hub = static_cast<std::int32_t>(first_free);
      if (is_free(hub) && couplings(hub) > 0) break;
    }
    if (first_free == graph.hubs()) return clusters;
    if (seed == none) seed = static_cast<std::int32_t>(first_free);
    const auto cluster = static_cast<std::int32_t>(clusters.size());
    clusters.emplace_back();
    shared.clear();
    while (seed != none && static_cast<std::int64_t>(clusters.back().size()) < size) {
      of_hub[index(seed)] = cluster;
      clusters.back().push_back(seed);
      for (const auto& [other, leaves] : graph.of(seed)) {
        if (is_free(other)) shared.add(other, leaves);
      }
      seed = shared.most(is_free, couplings);
    }
  }
}

// Clusters of less than half the size join a neighbour; empty ones stay behind.
void join_fragments(const HubGraph& graph, std::int64_t size,
                    std::vector<std::vector<std::int32_t>>& clusters,
                    std::vector<std::int32_t>& of_hub) {
  Tally shared(static_cast<std::int64_t>(clusters.size()));
  for (std::size_t g = 0; g < clusters.size(); ++g) {
    if (2 * static_cast<std::int64_t>(clusters[g].size()) >= size) continue;
    shared.clear();
    for (const std::int32_t hub : clusters[g]) {
      for (const auto& [other, leaves] : graph.of(hub)) shared.add(of_hub[index(other)], leaves);
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

void require_graph_memory(const BlockLayout& layout, ThreadPool& pool, double memory_limit) {
  const double pairs = most_reduced_blocks(layout, Side::leaves, pool);
  const double bytes = HubGraph::bytes_per_pair * pairs;
  const std::string what = "a graph of " + std::to_string(layout.hubs) + " blocks";
  require_memory(bytes, what);
  require_memory(bytes, memory_limit, what);
}

// A hub and those after it with leaves in common.
struct SharedLeaves {
  std::int32_t hub, other, leaves;
};

std::vector<SharedLeaves> shared_leaves(const BlockLayout& layout, std::int64_t first,
                                        std::int64_t last) {
  std::vector<SharedLeaves> result;
  const Incidence& hubs = layout.hub_side;
  const Incidence& leaves = layout.leaf_side;
  Tally shared(layout.hubs);
  for (std::int64_t hub = first; hub < last; ++hub) {
    shared.clear();
    for (std::int64_t p = hubs.begin[index(hub)]; p < hubs.begin[index(hub + 1)]; ++p) {
      const std::int32_t leaf = leaves.block[index(hubs.list[index(p)])];
      // Hubs of a leaf are in order.
      for (std::int64_t c = leaves.begin[index(leaf + 1)] - 1; hubs.block[index(c)] > hub; --c) {
        shared.add(hubs.block[index(c)]);
      }
    }
    for (const std::int32_t other : shared.counted()) {
      result.push_back(
          {static_cast<std::int32_t>(hub), other, static_cast<std::int32_t>(shared.shared(other))});
    }
  }
  return result;
}

}  // namespace

HubGraph hub_graph(const BlockLayout& layout, ThreadPool& pool, double memory_limit) {
  require_graph_memory(layout, pool, memory_limit);
  const Chunks pieces = chunks(layout.hubs, 16);
  std::vector<std::vector<SharedLeaves>> pairs(index(pieces.pieces));
  pool.run(pieces.pieces, [&](std::int64_t piece) {
    pairs[index(piece)] = shared_leaves(layout, pieces.begin(piece), pieces.end(piece));
  });

  HubGraph graph;
  graph.begin.assign(index(layout.hubs + 1), 0);
  for (const auto& part : pairs) {
    for (const auto& [hub, other, leaves] : part) {
      ++graph.begin[index(hub) + 1];
      ++graph.begin[index(other) + 1];
    }
  }
  std::partial_sum(graph.begin.begin(), graph.begin.end(), graph.begin.begin());
  graph.neighbours.resize(index(graph.begin.back()));
  std::vector<std::int64_t> next(graph.begin.begin(), graph.begin.end() - 1);
  for (const auto& part : pairs) {
    for (const auto& [hub, other, leaves] : part) {
      graph.neighbours[index(next[index(hub)]++)] = {other, leaves};
      graph.neighbours[index(next[index(other)]++)] = {hub, leaves};
    }
  }
  graph.couplings.resize(index(layout.hubs));
  const auto& begin = layout.hub_side.begin;
  for (std::int64_t h = 0; h < layout.hubs; ++h) {
    graph.couplings[index(h)] = static_cast<std::int32_t>(begin[index(h + 1)] - begin[index(h)]);
  }
  return graph;
}

HubClusters cluster_hubs(const HubGraph& graph, std::int64_t size) {
  HubClusters result;
  result.of_hub.assign(index(graph.hubs()), none);
  auto clusters = grow(graph, size, result.of_hub);
  join_fragments(graph, size, clusters, result.of_hub);
  std::erase_if(clusters, [](const auto& hubs) { return hubs.empty(); });
  if (clusters.empty() && graph.hubs() > 0) clusters.emplace_back();
  for (std::int32_t h = 0; index(h) < result.of_hub.size(); ++h) {
    if (result.of_hub[index(h)] == none) clusters.front().push_back(h);
  }
  result.begin.push_back(0);
  for (auto& hubs : clusters) {
    std::sort(hubs.begin(), hubs.end());
    for (const std::int32_t hub : hubs) {
      result.of_hub[index(hub)] = static_cast<std::int32_t>(result.begin.size()) - 1;
    }
    result.hubs.insert(result.hubs.end(), hubs.begin(), hubs.end());
    result.begin.push_back(static_cast<std::int64_t>(result.hubs.size()));
  }
  return result;
}

}  // namespace raybundle::linalg
