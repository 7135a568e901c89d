#include <raybundle/linalg/normal_equations.h>

#include <algorithm>

namespace raybundle::linalg {

NormalEquations::NormalEquations(const BlockLayout& block_layout)
    : layout(&block_layout),
      B(index(layout->size(Side::hubs) * layout->hub_size)),
      C(index(layout->size(Side::leaves) * layout->leaf_size)),
      gradient(index(layout->unknowns())) {
  if (!layout->anchored()) return;
  own_gradient_.resize(index(layout->size(Side::hubs)));
  hub_diagonal_.resize(own_gradient_.size());
  products_.resize(index(layout->anchors() * (layout->leaf_size + 1) * layout->hub_size));
}

void NormalEquations::form(const BlockJacobian& J, const double* r, ThreadPool& pool) {
  const BlockKernels& kernels = block_kernels(*layout);
  const NormalView normal = {B.data(),
                             C.data(),
                             gradient.data(),
                             gradient.data() + layout->offset(Side::leaves),
                             own_gradient_.data(),
                             hub_diagonal_.data(),
                             products_.data()};
  for (const Side side : {Side::leaves, Side::hubs}) {  // anchors take from their leaves
    const auto kernel =
        side == Side::hubs ? kernels.normal_blocks_hubs : kernels.normal_blocks_leaves;
    for_blocks(*layout, side, pool, [&](std::int64_t first, std::int64_t last) {
      kernel(view(J), r, first, last, normal);
    });
  }
}

void NormalEquations::diagonal_blocks(const BlockJacobian& J, Side side, std::vector<double>& H,
                                      ThreadPool& pool) const {
  H = side == Side::hubs ? B : C;
  const auto kernel = block_kernels(*layout).add_anchor_blocks;
  if (side == Side::leaves || kernel == nullptr) return;
  for_blocks(*layout, Side::hubs, pool, [&](std::int64_t first, std::int64_t last) {
    kernel(view(J), products_.data(), first, last, H.data());
  });
}

// Calls visit(i, H_ii) for all unknowns.
template <class Visit>
void NormalEquations::for_diagonal(Visit&& visit) const {
  std::size_t i = 0;
  for (const double d : hub_diagonal_) visit(i++, d);
  for (const Side side : {Side::hubs, Side::leaves}) {
    if (side == Side::hubs && layout->anchored()) continue;
    const int size = layout->block_size(side);
    const double* block = blocks(side);
    for (std::int64_t b = 0; b < layout->block_count(side); ++b, block += size * size) {
      for (int k = 0; k < size; ++k) visit(i++, block[k * size + k]);
    }
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
