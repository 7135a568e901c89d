#include <raybundle/linalg/block_jacobian.h>

#include <raybundle/linalg/vector.h>

namespace raybundle::linalg {
namespace {

template <class List>
const typename List::value_type* data_or_null(const List& list) {
  return list.empty() ? nullptr : list.data();
}

}  // namespace

BlockJacobian::BlockJacobian(const BlockLayout& block_layout)
    : layout(&block_layout),
      hub_blocks(index(layout->residuals() * layout->hub_size)),
      leaf_blocks(index(layout->residuals() * layout->leaf_size)),
      anchor_blocks(index(layout->anchors() * layout->leaf_size * layout->hub_size)) {}

double BlockJacobian::memory(const LayoutSize& n) {
  const double of_row = n.block.row * (n.block.hub + n.block.leaf);
  const double of_leaf = n.anchors * n.block.leaf * n.block.hub;
  return 8 * (of_row * static_cast<double>(n.rows) + of_leaf * static_cast<double>(n.leaves));
}

const BlockKernels& block_kernels(const BlockLayout& layout) {
  return block_kernels(layout.anchored(), layout.row_size, layout.hub_size, layout.leaf_size);
}

const EliminationKernels& elimination_kernels(const BlockLayout& layout, Side eliminated) {
  return elimination_kernels(layout.anchored(), layout.row_size,
                             layout.block_size(opposite(eliminated)),
                             layout.block_size(eliminated));
}

SideView side_view(const BlockLayout& layout, Side side) {
  const Incidence& incidence = layout.incidence(side);
  return {incidence.begin.data(), data_or_null(incidence.list), nullptr, incidence.block.data(),
          data_or_null(layout.coupling_rows)};
}

AnchorView anchor_view(const BlockJacobian& J) {
  const Anchorage& anchorage = J.layout->anchorage;
  return {data_or_null(anchorage.begin), data_or_null(anchorage.coupling),
          data_or_null(anchorage.anchor), data_or_null(J.anchor_blocks)};
}

JacobianView view(const BlockJacobian& J) {
  return {side_view(*J.layout, Side::hubs), side_view(*J.layout, Side::leaves), J.hub_blocks.data(),
          J.leaf_blocks.data(), anchor_view(J)};
}

void multiply(const BlockJacobian& J, const double* x, double* u, ThreadPool& pool) {
  const BlockLayout& layout = *J.layout;
  const double* x_leaf = x + layout.offset(Side::leaves);
  for_blocks(layout, Side::leaves, pool, [&](std::int64_t first, std::int64_t last) {
    block_kernels(layout).multiply(view(J), x, x_leaf, first, last, u);
  });
}

void transpose_multiply_leaves(const BlockJacobian& J, const double* u, double* y,
                               ThreadPool& pool) {
  for_blocks(*J.layout, Side::leaves, pool, [&](std::int64_t first, std::int64_t last) {
    block_kernels(*J.layout).transpose_multiply_leaves(view(J), u, first, last, y);
  });
}

void transpose_multiply_hubs(const BlockJacobian& J, const double* u, const double* w, double* y,
                             ThreadPool& pool) {
  for_blocks(*J.layout, Side::hubs, pool, [&](std::int64_t first, std::int64_t last) {
    block_kernels(*J.layout).transpose_multiply_hubs(view(J), u, w, first, last, y);
  });
}

double multiply_squares(const BlockJacobian& J, const double* x, double* u, ThreadPool& pool) {
  multiply(J, x, u, pool);
  return dot(u, u, J.layout->residuals(), pool);
}

void transpose_multiply(const BlockJacobian& J, const double* u, double* y, ThreadPool& pool) {
  double* of_leaves = y + J.layout->offset(Side::leaves);
  transpose_multiply_leaves(J, u, of_leaves, pool);
  transpose_multiply_hubs(J, u, of_leaves, y, pool);
}

}  // namespace raybundle::linalg
