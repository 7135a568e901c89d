#include <raybundle/linalg/normal_equations.h>

#include <algorithm>

namespace raybundle::linalg {

NormalEquations::NormalEquations(const BlockLayout& block_layout)
    : layout(&block_layout),
      C(index(layout->size(Side::leaves) * layout->leaf_size)),
      gradient(index(layout->unknowns())),
      hub_diagonal_(index(layout->size(Side::hubs))),
      own_gradient_(layout->anchored() ? hub_diagonal_.size() : 0) {}

NormalEquations::TileEnd NormalEquations::tile_end(std::int64_t row, std::int64_t leaf,
                                                   std::int64_t last_leaf) const {
  const std::int64_t full = row + tile_rows;
  if (layout->first_row(leaf + 1) > full) return {leaf, full};
  while (leaf < last_leaf && layout->first_row(leaf + 1) <= full) ++leaf;
  return {leaf, layout->first_row(leaf)};
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
    H = C;
    return;
  }
  H.resize(index(layout->size(side) * layout->hub_size));
  for_blocks(*layout, side, pool, [&](std::int64_t first, std::int64_t last) {
    block_kernels(J).hub_squares(J.view(), C.data(), first, last, H.data());
  });
}

// Calls visit(i, H_ii) for all unknowns.
template <class Visit>
void NormalEquations::for_diagonal(Visit&& visit) const {
  std::size_t i = 0;
  for (const double d : hub_diagonal_) visit(i++, d);
  const int size = layout->leaf_size;
  for (std::size_t b = 0; b < C.size(); b += index(size * size)) {
    for (int k = 0; k < size; ++k) visit(i++, C[b + index(k * size + k)]);
  }
}

void NormalEquations::diagonal(double low, double high, double* d) const {
  for_diagonal([&](std::size_t i, double value) { d[i] = std::clamp(value, low, high); });
}

double NormalEquations::scaled_gradient_squares() const {
  double sum = 0;
  for_diagonal([&](std::size_t i, double value) {
    if (value > 0) sum += gradient[i] * gradient[i] / value;
  });
  return sum;
}

}  // namespace raybundle::linalg
