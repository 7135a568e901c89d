#include <raybundle/linalg/normal_equations.h>

#include <raybundle/linalg/vector.h>

#include <algorithm>

namespace raybundle::linalg {

NormalEquations::NormalEquations(const BlockLayout& block_layout)
    : layout(&block_layout),
      C(index(layout->size(Side::leaves) * layout->leaf_size)),
      gradient(index(layout->unknowns())),
      hub_diagonal_(index(layout->size(Side::hubs))),
      own_gradient_(layout->anchored() ? hub_diagonal_.size() : 0) {}

double NormalEquations::memory(const LayoutSize& n) {
  const auto hubs = static_cast<double>(n.size(Side::hubs));
  const auto blocks = static_cast<double>(n.size(Side::leaves) * n.block.leaf);
  return 8 * (blocks + static_cast<double>(n.unknowns()) + (n.anchored() ? 2 : 1) * hubs) +
         HubSums::memory(n, std::int64_t{n.block.hub} * sums_of_hub(n.anchored()));
}

NormalEquations::TileEnd NormalEquations::tile_end(std::int64_t row, std::int64_t leaf,
                                                   std::int64_t last_leaf) const {
  const std::span<const std::int64_t> rows = layout->leaf_rows();
  const std::int64_t full = row + tile_rows;
  if (rows[index(leaf + 1)] > full) return {leaf, full};
  while (leaf < last_leaf && rows[index(leaf + 1)] <= full) ++leaf;
  return {leaf, rows[index(leaf)]};
}

// From what was summed by hub.
void NormalEquations::collect(const double* sums) {
  const int size = layout->hub_size;
  const int rows = sums_of_hub(layout->anchored());
  for (std::int64_t i = 0; i < layout->size(Side::hubs); ++i) {
    const double* of_hub = sums + i / size * size * rows + i % size;
    hub_diagonal_[index(i)] = of_hub[0];
    gradient[index(i)] = of_hub[size];
    if (!layout->anchored()) continue;
    own_gradient_[index(i)] = of_hub[size];
    gradient[index(i)] += of_hub[2 * size];
  }
}

void NormalEquations::diagonal_blocks(const BlockJacobian& J, Side side, std::vector<double>& H,
                                      ThreadPool& pool) const {
  if (side == Side::leaves) {
    H.assign(C.begin(), C.end());
    return;
  }
  H.resize(index(layout->size(side) * layout->hub_size));
  for_blocks(*layout, side, pool, [&](std::int64_t first, std::int64_t last) {
    block_kernels(J).hub_squares(J.view(), C.data(), first, last, H.data());
  });
}

double NormalEquations::diagonal_entry(std::int64_t i) const {
  const std::int64_t of_leaves = i - layout->offset(Side::leaves);
  if (of_leaves < 0) return hub_diagonal_[index(i)];
  const int size = layout->leaf_size;
  return C[index(of_leaves * size + of_leaves % size)];
}

void NormalEquations::diagonal(double low, double high, double* d, ThreadPool& pool) const {
  for_entries(layout->unknowns(), pool, [&](std::size_t i) {
    d[i] = std::clamp(diagonal_entry(static_cast<std::int64_t>(i)), low, high);
  });
}

double NormalEquations::scaled_gradient_squares(std::int64_t unknowns, ThreadPool& pool) const {
  return parallel_sum(pool, unknowns, 8192, [&](std::int64_t first, std::int64_t last) {
    double sum = 0;
    for (std::int64_t i = first; i < last; ++i) {
      const double value = diagonal_entry(i);
      if (value > 0) sum += gradient[index(i)] * gradient[index(i)] / value;
    }
    return sum;
  });
}

}  // namespace raybundle::linalg
