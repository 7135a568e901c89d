#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace raybundle::init {

/// An edge between two nodes, of some worth.
struct WeightedEdge {
  std::int32_t i, j;
  double weight;
};

/// The connected components of nodes 0 .. nodes - 1.
struct Components {
  std::vector<std::int32_t> of_node;
  std::vector<std::int64_t> size;  ///< nodes; component 0 is the largest, of equals the first

  bool in_largest(std::int32_t node) const { return of_node[static_cast<std::size_t>(node)] == 0; }
};
Components components(std::int64_t nodes, std::span<const WeightedEdge> edges);

/// The edges of a spanning tree of greatest weight of the component of `root`, each after those
/// that lead to it from the root; `parent` is the end nearer to the root.
struct TreeEdge {
  std::int32_t parent, child;
  std::int64_t edge;  ///< its place in the list
};
std::vector<TreeEdge> maximum_spanning_tree(std::int64_t nodes, std::span<const WeightedEdge> edges,
                                            std::int32_t root);

/// The edges of a spanning forest of greatest weight, one tree for each component: their places in
/// the list, of equal weights the first.
std::vector<std::int64_t> maximum_spanning_forest(std::int64_t nodes,
                                                  std::span<const WeightedEdge> edges);

}  // namespace raybundle::init
