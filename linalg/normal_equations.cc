#include <raybundle/linalg/normal_equations.h>

#include <algorithm>

namespace raybundle::linalg {

NormalEquations::NormalEquations(const BlockLayout& block_layout)
    : layout(&block_layout),
      B(index(layout->size(Side::hubs) * layout->hub_size)),
      C(index(layout->size(Side::leaves) * layout->leaf_size)),
      gradient(index(layout->unknowns())) {
  if (!layout->anchored()) return;
  own_B.resize(B.size());
  own_gradient.resize(index(layout->size(Side::hubs)));
  products.resize(index(layout->anchors() * (layout->leaf_size + 1) * layout->hub_size));
}

void NormalEquations::form(const BlockJacobian& J, const double* r, ThreadPool& pool) {
  const BlockKernels& kernels = block_kernels(*layout);
  const NormalView normal = {B.data(),        C.data(),
                             gradient.data(), gradient.data() + layout->offset(Side::leaves),
                             own_B.data(),    own_gradient.data(),
                             products.data()};
  for (const Side side : {Side::leaves, Side::hubs}) {  // anchors take from their leaves
    const auto kernel =
        side == Side::hubs ? kernels.normal_blocks_hubs : kernels.normal_blocks_leaves;
    for_blocks(*layout, side, pool, [&](std::int64_t first, std::int64_t last) {
      kernel(view(J), r, first, last, normal);
    });
  }
}

void NormalEquations::diagonal(double low, double high, double* d) const {
  for (const Side side : {Side::hubs, Side::leaves}) {
    const int size = layout->block_size(side);
    const double* block = blocks(side);
    for (std::int64_t b = 0; b < layout->block_count(side); ++b, block += size * size) {
      for (int i = 0; i < size; ++i) *d++ = std::clamp(block[i * size + i], low, high);
    }
  }
}

double NormalEquations::scaled_gradient_squares() const {
  double sum = 0;
  const double* g = gradient.data();
  for (const Side side : {Side::hubs, Side::leaves}) {
    const int size = layout->block_size(side);
    const double* block = blocks(side);
    for (std::int64_t b = 0; b < layout->block_count(side); ++b, block += size * size) {
      for (int i = 0; i < size; ++i, ++g) {
        const double d = block[i * size + i];
        if (d > 0) sum += *g * *g / d;
      }
    }
  }
  return sum;
}

}  // namespace raybundle::linalg
