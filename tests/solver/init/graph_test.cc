#include <raybundle/solver/init/graph.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/random.h>

namespace raybundle::init {
namespace {

std::vector<WeightedEdge> random_edges(std::int32_t nodes, int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<WeightedEdge> edges;
  while (static_cast<int>(edges.size()) < count) {
    const auto i = static_cast<std::int32_t>(random.below(nodes));
    const auto j = static_cast<std::int32_t>(random.below(nodes));
    if (i != j) edges.push_back({i, j, random.uniform()});
  }
  return edges;
}

TEST(Graph, ComponentsAreNumberedBySize) {
  const std::vector<WeightedEdge> edges = {{1, 2, 1}, {5, 4, 1}, {3, 4, 1}, {5, 3, 1}};
  const Components parts = components(7, edges);
  EXPECT_EQ(parts.of_node, (std::vector<std::int32_t>{2, 1, 1, 0, 0, 0, 3}));
  EXPECT_EQ(parts.size, (std::vector<std::int64_t>{3, 2, 1, 1}));
}

// No edge outside of the tree is better than one on the way between its ends: compared with what
// taking edges by weight, while they join two parts, gives.
TEST(Graph, TreesHaveTheGreatestWeight) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::int32_t nodes = 30;
    auto edges = random_edges(nodes, 200, seed);
    const auto tree = maximum_spanning_tree(nodes, edges, 3);
    ASSERT_EQ(tree.size(), 29U);
    double weight = 0;
    std::vector<bool> reached(30, false);
    reached[3] = true;
    for (const TreeEdge& step : tree) {
      EXPECT_TRUE(reached[static_cast<std::size_t>(step.parent)]);
      EXPECT_FALSE(reached[static_cast<std::size_t>(step.child)]);
      reached[static_cast<std::size_t>(step.child)] = true;
      weight += edges[static_cast<std::size_t>(step.edge)].weight;
    }
    std::sort(edges.begin(), edges.end(),
              [](const WeightedEdge& x, const WeightedEdge& y) { return x.weight > y.weight; });
    std::vector<WeightedEdge> taken;
    double expected = 0;
    for (const WeightedEdge& edge : edges) {
      const Components parts = components(nodes, taken);
      if (parts.of_node[static_cast<std::size_t>(edge.i)] ==
          parts.of_node[static_cast<std::size_t>(edge.j)]) {
        continue;
      }
      taken.push_back(edge);
      expected += edge.weight;
    }
    EXPECT_NEAR(weight, expected, 1e-12);
  }
}

TEST(Graph, TreesStayInTheComponentOfTheirRoot) {
  const std::vector<WeightedEdge> edges = {{0, 1, 1}, {2, 3, 5}};
  EXPECT_EQ(maximum_spanning_tree(5, edges, 0).size(), 1U);
  EXPECT_TRUE(maximum_spanning_tree(5, edges, 4).empty());
}

}  // namespace
}  // namespace raybundle::init
