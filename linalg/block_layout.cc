#include <raybundle/linalg/block_layout.h>

#include <numeric>

namespace raybundle::linalg {
namespace {

// Turns counts in begin[b + 1] into offsets.
void accumulate(std::vector<std::int64_t>& begin) {
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
}

Incidence leaf_incidence(std::int64_t leaves, std::vector<std::int32_t> block) {
  Incidence side;
  side.begin.assign(index(leaves + 1), 0);
  for (const std::int32_t leaf : block) ++side.begin[index(leaf) + 1];
  accumulate(side.begin);
  side.block = std::move(block);
  return side;
}

// Counting sort by hub: within a hub the couplings stay in order of their leaves.
Incidence hub_incidence(std::int64_t hubs, std::vector<std::int32_t> block) {
  Incidence side;
  side.begin.assign(index(hubs + 1), 0);
  for (const std::int32_t hub : block) ++side.begin[index(hub) + 1];
  accumulate(side.begin);
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
  layout.couplings = static_cast<std::int64_t>(leaf.size());
  if (layout.couplings == layout.rows) layout.coupling_rows = {};
  layout.leaf_side = leaf_incidence(leaves, std::move(leaf));
  layout.hub_side = hub_incidence(hubs, std::move(hub));
  return layout;
}

}  // namespace raybundle::linalg
