// Clusters of hubs: every hub is in one, they are of the size asked for, and they hold together.

#include <raybundle/linalg/hub_clusters.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/linalg/memory.h>

namespace raybundle::linalg {
namespace {

// Hubs in a row, each sharing leaves with its next neighbours; hub i is called name(i).
template <class Name>
BlockLayout chain(std::int32_t hubs, std::int32_t unobserved, Name&& name) {
  std::vector<std::int32_t> row_leaf, row_hub;
  std::int32_t leaf = 0;
  for (std::int32_t h = 0; h + 2 < hubs; ++h) {
    for (int copy = 0; copy < 3; ++copy, ++leaf) {
      std::vector<std::int32_t> seen = {name(h), name(h + 1)};
      if (copy == 0) seen.push_back(name(h + 2));
      std::sort(seen.begin(), seen.end());
      for (const std::int32_t hub : seen) row_leaf.push_back(leaf), row_hub.push_back(hub);
    }
  }
  return make_layout({2, 9, 3}, hubs + unobserved, leaf, row_leaf, row_hub);
}

HubClusters clusters_of(const BlockLayout& layout, std::int64_t size) {
  ThreadPool pool(2);
  return cluster_hubs(hub_graph(layout, pool), size);
}

TEST(HubGraph, CountsLeavesInCommonBothWays) {
  ThreadPool pool(2);
  const HubGraph graph = hub_graph(chain(40, 1, [](std::int32_t i) { return i; }), pool);
  ASSERT_EQ(graph.hubs(), 41);
  const auto shared = [&](std::int32_t a, std::int32_t b) {
    std::int32_t leaves = 0;
    for (const HubGraph::Neighbour& each : graph.of(a)) leaves += each.hub == b ? each.leaves : 0;
    return leaves;
  };
  for (std::int32_t h = 0; h < 41; ++h) {
    EXPECT_EQ(shared(h, h), 0);
    for (std::int32_t other = h + 1; other < 41; ++other) {
      const bool next = other == h + 1, after_next = other == h + 2;
      // Three leaves of a hub and its next; one of them has the hub after that too.
      const int expected = other == 40  ? 0
                           : next       ? (h == 38 ? 1 : (h == 0 ? 3 : 4))
                           : after_next ? 1
                                        : 0;
      EXPECT_EQ(shared(h, other), expected) << h << " " << other;
      EXPECT_EQ(shared(other, h), expected) << h << " " << other;
    }
  }
  EXPECT_EQ(graph.couplings[0], 3);
  EXPECT_EQ(graph.couplings[40], 0);
}

TEST(HubGraph, KeepsToAMemoryLimit) {
  ThreadPool pool(1);
  const BlockLayout layout = chain(40, 0, [](std::int32_t i) { return i; });
  // Pairs of hubs, and no fewer than that by the degrees of their leaves.
  const double pairs = 39 + 38, most = 38 * (6 + 3 + 3);
  EXPECT_NO_THROW(hub_graph(layout, pool, HubGraph::bytes_per_pair * most));
  EXPECT_THROW(hub_graph(layout, pool, HubGraph::bytes_per_pair * pairs - 1), MemoryRefusal);
}

TEST(HubClusters, FollowAChainWhateverTheOrderOfItsHubs) {
  constexpr std::int32_t hubs = 100;
  for (const std::int32_t stride : {1, 37}) {  // 37 has no factor in common with 100
    const auto name = [&](std::int32_t i) { return i * stride % hubs; };
    const HubClusters clusters = clusters_of(chain(hubs, 0, name), 10);
    ASSERT_EQ(clusters.of_hub.size(), 100U);
    EXPECT_GE(clusters.count(), 8);
    EXPECT_LE(clusters.count(), 11);
    int changes = 0;
    for (std::int32_t i = 1; i < hubs; ++i) {
      changes += clusters.of_hub[index(name(i))] != clusters.of_hub[index(name(i - 1))];
    }
    EXPECT_EQ(changes, clusters.count() - 1) << "each cluster is one piece of the chain";
  }
}

TEST(HubClusters, HaveNumbersFromZeroAndTakeHubsWithoutLeavesAlong) {
  const HubClusters clusters = clusters_of(chain(30, 4, [](std::int32_t i) { return i; }), 8);
  std::vector<int> sizes(index(clusters.count()), 0);
  for (std::int32_t h = 0; h < 30; ++h) ++sizes[index(clusters.of_hub[index(h)])];
  for (const int size : sizes) {
    EXPECT_GE(size, 4);
    EXPECT_LE(size, 12);
  }
  for (std::int32_t h = 30; h < 34; ++h) EXPECT_EQ(clusters.of_hub[index(h)], 0);
}

TEST(HubClusters, OneIsEnoughForFewHubs) {
  const HubClusters clusters = clusters_of(chain(5, 0, [](std::int32_t i) { return i; }), 8);
  EXPECT_EQ(clusters.count(), 1);
}

}  // namespace
}  // namespace raybundle::linalg
