#include <raybundle/linalg/block_layout.h>

#include <algorithm>
#include <numeric>

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

BlockLayout sized_layout(BlockSizes sizes, std::int64_t hubs, std::int64_t leaves,
                         std::size_t rows) {
  BlockLayout layout;
  layout.row_size = sizes.row;
  layout.hub_size = sizes.hub;
  layout.leaf_size = sizes.leaf;
  layout.rows = static_cast<std::int64_t>(rows);
  layout.hubs = hubs;
  layout.leaves = leaves;
  return layout;
}

void couple(BlockLayout& layout, std::vector<std::int32_t> leaf, std::vector<std::int32_t> hub) {
  layout.couplings = static_cast<std::int64_t>(leaf.size());
  layout.leaf_side = leaf_incidence(layout.leaves, std::move(leaf));
  layout.hub_side = hub_incidence(layout.hubs, std::move(hub));
}

std::vector<std::int64_t> rows_of_parts(const std::vector<std::int64_t>& row_parts) {
  std::vector<std::int64_t> row(index(row_parts.back()));
  for (std::size_t r = 0; r + 1 < row_parts.size(); ++r) {
    std::fill(row.begin() + row_parts[r], row.begin() + row_parts[r + 1],
              static_cast<std::int64_t>(r));
  }
  return row;
}

}  // namespace

BlockLayout make_layout(BlockSizes sizes, std::int64_t hubs, std::int64_t leaves,
                        const std::vector<std::int32_t>& row_leaf,
                        const std::vector<std::int32_t>& row_hub) {
  BlockLayout layout = sized_layout(sizes, hubs, leaves, row_leaf.size());
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
  couple(layout, std::move(leaf), std::move(hub));
  return layout;
}

// The couplings of a leaf are the distinct hubs of its parts. Sorting those parts by hub, in their
// own order within a hub, puts the parts of each coupling next to one another.
BlockLayout make_layout(BlockSizes sizes, std::int64_t hubs, std::int64_t leaves,
                        const std::vector<std::int32_t>& row_leaf,
                        std::vector<std::int64_t> row_parts, std::vector<std::int32_t> part_hub) {
  BlockLayout layout = sized_layout(sizes, hubs, leaves, row_leaf.size());
  RowParts& parts = layout.parts;
  parts.leaf_rows = begins(leaves, row_leaf);
  parts.row = rows_of_parts(row_parts);
  parts.row_parts = std::move(row_parts);
  parts.hub = std::move(part_hub);
  parts.list.resize(parts.hub.size());
  std::iota(parts.list.begin(), parts.list.end(), 0);

  std::vector<std::int32_t> leaf, hub;
  for (std::int64_t l = 0; l < leaves; ++l) {
    const std::int64_t first = parts.row_parts[index(parts.leaf_rows[index(l)])];
    const std::int64_t last = parts.row_parts[index(parts.leaf_rows[index(l + 1)])];
    std::stable_sort(parts.list.begin() + first, parts.list.begin() + last,
                     [&](auto a, auto b) { return parts.hub[index(a)] < parts.hub[index(b)]; });
    for (std::int64_t k = first; k < last; ++k) {
      const std::int32_t at = parts.hub[index(parts.list[index(k)])];
      if (k > first && hub.back() == at) continue;
      parts.coupling_begin.push_back(k);
      leaf.push_back(static_cast<std::int32_t>(l));
      hub.push_back(at);
    }
  }
  parts.coupling_begin.push_back(layout.part_count());
  couple(layout, std::move(leaf), std::move(hub));
  return layout;
}

}  // namespace raybundle::linalg
