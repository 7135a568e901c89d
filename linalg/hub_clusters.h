#pragma once

#include <raybundle/linalg/block_layout.h>
#include <raybundle/linalg/parallel.h>

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace raybundle::linalg {

/// Which hubs have leaves in common, and how many: both ways, without the hubs themselves.
struct HubGraph {
  struct Neighbour {
    std::int32_t hub;
    std::int32_t leaves;  ///< in common with it
  };
  std::vector<std::int64_t> begin;  ///< neighbours of hub h: [h] .. [h + 1], in any order
  std::vector<Neighbour> neighbours;
  std::vector<std::int32_t> couplings;  ///< of each hub

  std::int64_t hubs() const { return static_cast<std::int64_t>(couplings.size()); }
  std::span<const Neighbour> of(std::int64_t hub) const {
    return {neighbours.data() + begin[index(hub)], neighbours.data() + begin[index(hub + 1)]};
  }
  /// Of two hubs, while it is made.
  static constexpr double bytes_per_pair = 12 + 2 * sizeof(Neighbour);
};

/// Throws MemoryRefusal where it would take more than is available or than `memory_limit` bytes.
HubGraph hub_graph(const BlockLayout& layout, ThreadPool& pool,
                   double memory_limit = std::numeric_limits<double>::infinity());

/// Hubs in clusters of neighbours.
struct HubClusters {
  std::vector<std::int32_t> of_hub;  ///< the cluster of each hub
  std::vector<std::int64_t> begin;   ///< of a cluster in
  std::vector<std::int32_t> hubs;    ///< the hubs, cluster by cluster, ascending

  std::int64_t count() const { return static_cast<std::int64_t>(begin.size()) - 1; }
  std::span<const std::int32_t> of_cluster(std::int64_t g) const {
    return {hubs.data() + begin[index(g)], hubs.data() + begin[index(g + 1)]};
  }
};

/// Clusters of about `size` hubs, grown one after the other: always by the hub that shares most
/// leaves with the cluster so far. The next one starts where the last one would have gone on, so
/// that clusters follow a chain of hubs. Fragments join the neighbour they share most leaves with.
/// Hubs without leaves are in the first cluster.
HubClusters cluster_hubs(const HubGraph& graph, std::int64_t size);

}  // namespace raybundle::linalg
