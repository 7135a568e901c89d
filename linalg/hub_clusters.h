#pragma once

#include <raybundle/linalg/block_layout.h>

#include <vector>

namespace raybundle::linalg {

/// Hubs in clusters of neighbours.
struct HubClusters {
  std::int64_t count = 0;
  std::vector<std::int32_t> of_hub;  ///< the cluster of each hub
};

/// Clusters of about `size` hubs, grown one after the other: always by the hub that shares most
/// leaves with the cluster so far. The next one starts where the last one would have gone on, so
/// that clusters follow a chain of hubs. Fragments join the neighbour they share most leaves with.
/// Hubs without leaves are in the first cluster.
HubClusters cluster_hubs(const BlockLayout& layout, std::int64_t size);

}  // namespace raybundle::linalg
