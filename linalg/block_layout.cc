#include <raybundle/linalg/block_layout.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>

namespace raybundle::linalg {
namespace {

// Where the entries of each block begin, from the block of every entry.
std::vector<std::int64_t> begins(std::int64_t blocks, const std::vector<std::int32_t>& block) {
  std::vector<std::int64_t> begin(index(blocks + 1), 0);
  for (const std::int32_t b : block) ++begin[index(b) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  return begin;
}

Incidence leaf_incidence(std::int64_t leaves, std::vector<std::int32_t> block) {
  Incidence side;
  side.begin = begins(leaves, block);
  side.block = std::move(block);
  return side;
}

// Counting sort by hub: within a hub the couplings stay in order of their leaves.
Incidence hub_incidence(std::int64_t hubs, std::vector<std::int32_t> block) {
  Incidence side;
  side.begin = begins(hubs, block);
  std::vector<std::int64_t> next(side.begin.begin(), side.begin.end() - 1);
  side.list.resize(block.size());
  side.position.resize(block.size());
  for (std::size_t c = 0; c < block.size(); ++c) {
    const std::int64_t p = next[index(block[c])]++;
    side.list[index(p)] = static_cast<std::int64_t>(c);
    side.position[c] = p;
  }
  side.block = std::move(block);
  return side;
}

}  // namespace

BlockLayout make_layout(BlockSizes sizes, std::int64_t hubs, std::int64_t leaves,
                        const std::vector<std::int32_t>& row_leaf,
                        const std::vector<std::int32_t>& row_hub) {
  BlockLayout layout;
  layout.row_size = sizes.row;
  layout.hub_size = sizes.hub;
  layout.leaf_size = sizes.leaf;
  layout.rows = static_cast<std::int64_t>(row_leaf.size());
  layout.hubs = hubs;
  layout.leaves = leaves;
  std::vector<std::int32_t> leaf, hub;
  leaf.reserve(row_leaf.size());
  hub.reserve(row_leaf.size());
  for (std::size_t r = 0; r < row_leaf.size(); ++r) {
    const bool repeats = r > 0 && row_leaf[r] == row_leaf[r - 1] && row_hub[r] == row_hub[r - 1];
    if (repeats) continue;
    layout.coupling_rows.push_back(static_cast<std::int64_t>(r));
    leaf.push_back(row_leaf[r]);
    hub.push_back(row_hub[r]);
  }
  layout.coupling_rows.push_back(layout.rows);
  if (leaf.size() == row_leaf.size()) layout.coupling_rows = {};
  layout.couplings = static_cast<std::int64_t>(leaf.size());
  layout.leaf_side = leaf_incidence(leaves, std::move(leaf));
  layout.hub_side = hub_incidence(hubs, std::move(hub));
  return layout;
}

void anchor_leaves(BlockLayout& layout, const std::vector<LeafAnchors>& anchors) {
  if (anchors.size() != index(layout.leaves)) {
    throw std::invalid_argument("anchors of " + std::to_string(anchors.size()) + " leaves, not " +
                                std::to_string(layout.leaves));
  }
  Anchorage& anchorage = layout.anchorage;
  anchorage = {{0}, {}, std::vector<std::int64_t>(index(layout.couplings), -1)};
  const std::vector<std::int64_t>& begin = layout.leaf_side.begin;
  const std::vector<std::int32_t>& hub = layout.hub_side.block;
  for (std::size_t l = 0; l < anchors.size(); ++l) {
    for (const std::int32_t anchor : anchors[l]) {
      if (anchor < 0) continue;
      const auto first = hub.begin() + begin[l], last = hub.begin() + begin[l + 1];
      const auto found = std::lower_bound(first, last, anchor);
      if (found == last || *found != anchor) {
        throw std::invalid_argument("leaf " + std::to_string(l) + " has no row of its anchor " +
                                    std::to_string(anchor));
      }
      const std::int64_t coupling = found - hub.begin();
      if (anchorage.anchor[index(coupling)] >= 0) {
        throw std::invalid_argument("leaf " + std::to_string(l) + " has its anchor " +
                                    std::to_string(anchor) + " twice");
      }
      anchorage.anchor[index(coupling)] = layout.anchors();
      anchorage.coupling.push_back(coupling);
    }
    anchorage.begin.push_back(layout.anchors());
  }
}

}  // namespace raybundle::linalg
