#include <raybundle/solver/init/graph.h>

#include <raybundle/linalg/block_layout.h>

#include <algorithm>
#include <numeric>
#include <queue>
#include <tuple>

namespace raybundle::init {
namespace {

using linalg::index;

// The first node of the tree that a node is in; trees are flattened on the way.
std::int32_t first_of(std::vector<std::int32_t>& up, std::int32_t node) {
  while (up[index(node)] != node) node = up[index(node)] = up[index(up[index(node)])];
  return node;
}

// Edges at each node.
struct Neighbours {
  std::vector<std::int64_t> begin;
  std::vector<std::int64_t> edge;

  Neighbours(std::int64_t nodes, std::span<const WeightedEdge> edges)
      : begin(index(nodes + 1), 0), edge(2 * edges.size()) {
    for (const WeightedEdge& each : edges) ++begin[index(each.i) + 1], ++begin[index(each.j) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::int64_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t k = 0; k < edges.size(); ++k) {
      edge[index(next[index(edges[k].i)]++)] = static_cast<std::int64_t>(k);
      edge[index(next[index(edges[k].j)]++)] = static_cast<std::int64_t>(k);
    }
  }
};

}  // namespace

Components components(std::int64_t nodes, std::span<const WeightedEdge> edges) {
  std::vector<std::int32_t> up(index(nodes));
  std::iota(up.begin(), up.end(), 0);
  for (const WeightedEdge& edge : edges) {
    const std::int32_t i = first_of(up, edge.i), j = first_of(up, edge.j);
    up[index(std::max(i, j))] = std::min(i, j);
  }
  std::vector<std::int64_t> size(index(nodes), 0);
  for (std::int32_t node = 0; node < nodes; ++node) ++size[index(first_of(up, node))];
  std::vector<std::int32_t> firsts;
  for (std::int32_t node = 0; node < nodes; ++node) {
    if (size[index(node)] > 0) firsts.push_back(node);
  }
  std::stable_sort(firsts.begin(), firsts.end(),
                   [&](std::int32_t x, std::int32_t y) { return size[index(x)] > size[index(y)]; });
  Components result;
  std::vector<std::int32_t> number(index(nodes), 0);
  for (const std::int32_t first : firsts) {
    number[index(first)] = static_cast<std::int32_t>(result.size.size());
    result.size.push_back(size[index(first)]);
  }
  result.of_node.reserve(index(nodes));
  for (std::int32_t node = 0; node < nodes; ++node) {
    result.of_node.push_back(number[index(first_of(up, node))]);
  }
  return result;
}

// Grown from the root, always by the best edge that leads out; of equals the first.
std::vector<TreeEdge> maximum_spanning_tree(std::int64_t nodes, std::span<const WeightedEdge> edges,
                                            std::int32_t root) {
  const Neighbours neighbours(nodes, edges);
  std::vector<std::uint8_t> reached(index(nodes), 0);
  std::vector<TreeEdge> tree;
  using Candidate = std::tuple<double, std::int64_t, std::int32_t>;  // weight, -edge, parent
  std::priority_queue<Candidate> candidates;
  const auto reach = [&](std::int32_t node) {
    reached[index(node)] = 1;
    for (std::int64_t k = neighbours.begin[index(node)]; k < neighbours.begin[index(node) + 1];
         ++k) {
      const std::int64_t e = neighbours.edge[index(k)];
      candidates.emplace(edges[index(e)].weight, -e, node);
    }
  };
  reach(root);
  while (!candidates.empty()) {
    const auto [weight, minus_edge, parent] = candidates.top();
    candidates.pop();
    const WeightedEdge& edge = edges[index(-minus_edge)];
    const std::int32_t child = edge.i == parent ? edge.j : edge.i;
    if (reached[index(child)] != 0) continue;
    tree.push_back({parent, child, -minus_edge});
    reach(child);
  }
  return tree;
}

// The heaviest edges that join two trees [Kruskal56].
std::vector<std::int64_t> maximum_spanning_forest(std::int64_t nodes,
                                                  std::span<const WeightedEdge> edges) {
  std::vector<std::int64_t> order(edges.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::int64_t x, std::int64_t y) {
    return edges[index(x)].weight > edges[index(y)].weight;
  });
  std::vector<std::int32_t> up(index(nodes));
  std::iota(up.begin(), up.end(), 0);
  std::vector<std::int64_t> forest;
  for (const std::int64_t k : order) {
    const std::int32_t i = first_of(up, edges[index(k)].i), j = first_of(up, edges[index(k)].j);
    if (i == j) continue;
    up[index(std::max(i, j))] = std::min(i, j);
    forest.push_back(k);
  }
  return forest;
}

}  // namespace raybundle::init
