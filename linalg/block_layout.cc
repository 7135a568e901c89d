#include <raybundle/linalg/block_layout.h>

#include <raybundle/linalg/vector.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace raybundle::linalg {
namespace {

constexpr std::int64_t row_grain = 16384;

// Whether row r has the pair of the one before.
bool repeats(const RowBlocks& rows, std::size_t r) {
  return r > 0 && rows.leaf[r] == rows.leaf[r - 1] && rows.hub[r] == rows.hub[r - 1];
}

bool any_repetition(const RowBlocks& rows, ThreadPool& pool) {
  std::atomic<bool> any = false;
  for_entries(static_cast<std::int64_t>(rows.leaf.size()), pool, [&](std::size_t r) {
    if (repeats(rows, r)) any.store(true, std::memory_order_relaxed);
  });
  return any;
}

// Rows that repeat a pair join its coupling: the lists of couplings are shorter than those of rows.
void merge_repetitions(RowBlocks rows, BlockLayout& layout) {
  LargeVector<std::int32_t>& leaf = layout.leaf_side.block;
  LargeVector<std::int32_t>& hub = layout.hub_side.block;
  LargeVector<std::int64_t>& begin = layout.leaf_side.begin;
  begin.assign(index(layout.leaves + 1), 0);
  for (std::size_t r = 0; r < rows.leaf.size(); ++r) {
    if (repeats(rows, r)) continue;
    layout.coupling_rows.push_back(static_cast<std::int64_t>(r));
    leaf.push_back(rows.leaf[r]);
    hub.push_back(rows.hub[r]);
    ++begin[index(rows.leaf[r]) + 1];
  }
  layout.coupling_rows.push_back(layout.rows);
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  layout.repeated = std::move(rows);
}

// Counting sort by hub: within a hub the couplings stay in order of their leaves. Every piece of
// them counts for itself, and then knows where its own begin.
void sort_by_hub(std::int64_t hubs, Incidence& side, ThreadPool& pool) {
  const auto couplings = static_cast<std::int64_t>(side.block.size());
  const Chunks pieces =
      chunks(couplings, row_grain, std::min(max_chunks, couplings / (2 * hubs + 1)));
  std::vector<std::int32_t> next(index(std::max<std::int64_t>(pieces.pieces, 1) * hubs), 0);
  pool.run(pieces.pieces, [&](std::int64_t piece) {
    std::int32_t* count = next.data() + piece * hubs;
    for (std::int64_t c = pieces.begin(piece); c < pieces.end(piece); ++c) {
      ++count[side.block[index(c)]];
    }
  });
  side.begin.assign(1, 0);
  for (std::int64_t h = 0; h < hubs; ++h) {
    std::int64_t at = side.begin.back();
    for (std::int64_t piece = 0; piece < pieces.pieces; ++piece) {
      const std::int32_t count = next[index(piece * hubs + h)];
      next[index(piece * hubs + h)] = static_cast<std::int32_t>(at);
      at += count;
    }
    side.begin.push_back(at);
  }
  side.list.resize(index(couplings));
  pool.run(pieces.pieces, [&](std::int64_t piece) {
    std::int32_t* at = next.data() + piece * hubs;
    for (std::int64_t c = pieces.begin(piece); c < pieces.end(piece); ++c) {
      side.list[index(at[side.block[index(c)]]++)] = static_cast<std::int32_t>(c);
    }
  });
}

void require_numbers(const char* what, std::int64_t count) {
  if (count <= most_numbered) return;
  throw std::length_error(std::to_string(count) + " " + what + ", and no more than " +
                          std::to_string(most_numbered) + " can be numbered");
}

}  // namespace

double BlockLayout::memory(const LayoutSize& n) {
  const auto rows = static_cast<double>(n.rows);
  const auto leaves = static_cast<double>(n.leaves), hubs = static_cast<double>(n.hubs);
  const double anchorage = n.anchored() ? 4 * rows + (8 + 4 * n.anchors) * leaves : 0;
  return 12 * rows + 8 * (leaves + hubs) + anchorage;
}

LargeVector<std::int32_t> positions(const Incidence& side) {
  LargeVector<std::int32_t> position(side.list.size());
  for (std::size_t p = 0; p < side.list.size(); ++p) {
    position[index(side.list[p])] = static_cast<std::int32_t>(p);
  }
  return position;
}

BlockLayout make_layout(BlockSizes sizes, std::int64_t hubs, std::int64_t leaves, RowBlocks rows,
                        ThreadPool& pool) {
  BlockLayout layout;
  layout.row_size = sizes.row;
  layout.hub_size = sizes.hub;
  layout.leaf_size = sizes.leaf;
  layout.rows = static_cast<std::int64_t>(rows.leaf.size());
  layout.hubs = hubs;
  layout.leaves = leaves;
  require_numbers("rows", layout.rows);
  require_numbers("blocks", hubs + leaves);
  if (any_repetition(rows, pool)) {
    merge_repetitions(std::move(rows), layout);
  } else {
    layout.leaf_side.begin = std::move(rows.begin);
    layout.leaf_side.block = std::move(rows.leaf);
    layout.hub_side.block = std::move(rows.hub);
  }
  layout.couplings = static_cast<std::int64_t>(layout.leaf_side.block.size());
  sort_by_hub(hubs, layout.hub_side, pool);
  return layout;
}

BlockLayout make_layout(BlockSizes sizes, std::int64_t hubs, std::int64_t leaves,
                        const std::vector<std::int32_t>& row_leaf,
                        const std::vector<std::int32_t>& row_hub) {
  RowBlocks rows = {{row_leaf.begin(), row_leaf.end()}, {row_hub.begin(), row_hub.end()}, {}};
  rows.begin.assign(index(leaves + 1), 0);
  for (const std::int32_t leaf : row_leaf) ++rows.begin[index(leaf) + 1];
  std::partial_sum(rows.begin.begin(), rows.begin.end(), rows.begin.begin());
  ThreadPool alone(1);
  return make_layout(sizes, hubs, leaves, std::move(rows), alone);
}

void anchor_leaves(BlockLayout& layout, const std::vector<LeafAnchors>& anchors) {
  if (anchors.size() != index(layout.leaves)) {
    throw std::invalid_argument("anchors of " + std::to_string(anchors.size()) + " leaves, not " +
                                std::to_string(layout.leaves));
  }
  Anchorage& anchorage = layout.anchorage;
  anchorage = {{0}, {}, std::vector<std::int32_t>(index(layout.couplings), -1)};
  const LargeVector<std::int64_t>& begin = layout.leaf_side.begin;
  const LargeVector<std::int32_t>& hub = layout.hub_side.block;
  for (std::size_t l = 0; l < anchors.size(); ++l) {
    for (const std::int32_t anchor : anchors[l]) {
      if (anchor < 0) continue;
      const auto first = hub.begin() + begin[l], last = hub.begin() + begin[l + 1];
      const auto found = std::lower_bound(first, last, anchor);
      if (found == last || *found != anchor) {
        throw std::invalid_argument("leaf " + std::to_string(l) + " has no row of its anchor " +
                                    std::to_string(anchor));
      }
      const auto coupling = static_cast<std::int32_t>(found - hub.begin());
      if (anchorage.anchor[index(coupling)] >= 0) {
        throw std::invalid_argument("leaf " + std::to_string(l) + " has its anchor " +
                                    std::to_string(anchor) + " twice");
      }
      anchorage.anchor[index(coupling)] = static_cast<std::int32_t>(layout.anchors());
      anchorage.coupling.push_back(coupling);
    }
    anchorage.begin.push_back(layout.anchors());
  }
}

}  // namespace raybundle::linalg
