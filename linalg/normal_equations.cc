#include <raybundle/linalg/normal_equations.h>

#include <algorithm>

namespace raybundle::linalg {

NormalEquations::NormalEquations(const BlockLayout& block_layout)
    : layout(&block_layout),
      C(index(layout->size(Side::leaves) * layout->leaf_size)),
      gradient(index(layout->unknowns())),
      hub_diagonal_(index(layout->size(Side::hubs))),
      own_gradient_(layout->anchored() ? hub_diagonal_.size() : 0) {}

void NormalEquations::form(const BlockJacobian& J, const double* r, ThreadPool& pool) {
  const BlockKernels& kernels = block_kernels(*layout);
  double* g_leaf = gradient.data() + layout->offset(Side::leaves);
  const int size = layout->hub_size;
  const int rows = sums_of_hub(layout->anchored());
  const double* sums = sums_.form(
      *layout, std::int64_t{size} * rows, pool,
      [&](std::int64_t first, std::int64_t last, std::int64_t /*piece*/, double* of_hubs) {
        kernels.normal_equations(view(J), r, first, last, {C.data(), g_leaf, of_hubs});
      });
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
    block_kernels(*layout).hub_squares(view(J), C.data(), first, last, H.data());
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
