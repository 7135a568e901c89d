#include <raybundle/linalg/block_jacobian.h>

namespace raybundle::linalg {
namespace {

template <class List>
const typename List::value_type* data_or_null(const List& list) {
  return list.empty() ? nullptr : list.data();
}

}  // namespace

BlockJacobian::BlockJacobian(const BlockLayout& block_layout, Precision precision)
    : anchor_blocks(index(block_layout.anchors() * block_layout.leaf_size * block_layout.hub_size)),
      layout_(&block_layout) {
  set_precision(precision);
}

void BlockJacobian::set_precision(Precision precision) {
  precision_ = precision;
  hub_blocks_ = {};  // both go before either comes
  leaf_blocks_ = {};
  const std::int64_t residual_bytes = bytes(precision) * layout_->residuals();
  hub_blocks_.resize(index(residual_bytes * layout_->hub_size));
  leaf_blocks_.resize(index(residual_bytes * layout_->leaf_size));
}

double BlockJacobian::memory(const LayoutSize& n, Precision precision) {
  const double of_row = n.block.row * (n.block.hub + n.block.leaf);
  const double of_leaf = n.anchors * n.block.leaf * n.block.hub;
  return static_cast<double>(bytes(precision)) * of_row * static_cast<double>(n.rows) +
         8 * of_leaf * static_cast<double>(n.leaves);
}

std::int64_t BlockJacobian::place(Side side, std::int64_t row, int r, int k) const {
  const int rows = layout_->row_size, columns = layout_->block_size(side);
  return row * rows * columns + (in_pairs(rows) ? k * rows + r : r * columns + k);
}

double BlockJacobian::at(Side side, std::int64_t row, int r, int k) const {
  const std::int64_t i = place(side, row, r, k);
  return precision_ == Precision::single_precision
             ? double{static_cast<const float*>(blocks(side))[i]}
             : static_cast<const double*>(blocks(side))[i];
}

void BlockJacobian::set(Side side, std::int64_t row, int r, int k, double value) {
  const std::int64_t i = place(side, row, r, k);
  void* numbers = const_cast<void*>(blocks(side));
  if (precision_ == Precision::single_precision) {
    static_cast<float*>(numbers)[i] = static_cast<float>(value);
  } else {
    static_cast<double*>(numbers)[i] = value;
  }
}

KernelShape kernel_shape(const BlockLayout& layout, Precision precision) {
  return {precision, layout.anchored(), layout.row_size, layout.hub_size, layout.leaf_size};
}

const BlockKernels& block_kernels(const BlockJacobian& J) {
  return block_kernels(kernel_shape(J.layout(), J.precision()));
}

SideView side_view(const BlockLayout& layout, Side side) {
  const Incidence& incidence = layout.incidence(side);
  return {incidence.begin.data(), data_or_null(incidence.list), nullptr, incidence.block.data(),
          data_or_null(layout.coupling_rows)};
}

JacobianView BlockJacobian::view() const {
  const Anchorage& anchorage = layout_->anchorage;
  return {side_view(*layout_, Side::hubs),
          side_view(*layout_, Side::leaves),
          hub_blocks_.data(),
          leaf_blocks_.data(),
          {data_or_null(anchorage.begin), data_or_null(anchorage.coupling),
           data_or_null(anchorage.anchor), data_or_null(anchor_blocks)}};
}

void multiply(const BlockJacobian& J, const double* x, double* u, ThreadPool& pool) {
  const BlockLayout& layout = J.layout();
  const double* x_leaf = x + layout.offset(Side::leaves);
  for_blocks(layout, Side::leaves, pool, [&](std::int64_t first, std::int64_t last) {
    block_kernels(J).multiply(J.view(), x, x_leaf, first, last, u);
  });
}

double multiply_squares(const BlockJacobian& J, const double* x, ThreadPool& pool) {
  const BlockLayout& layout = J.layout();
  const double* x_leaf = x + layout.offset(Side::leaves);
  return parallel_sum(pool, layout.leaves, 128, [&](std::int64_t first, std::int64_t last) {
    return block_kernels(J).squares(J.view(), x, x_leaf, first, last);
  });
}

void transpose_multiply_leaves(const BlockJacobian& J, const double* u, double* y,
                               ThreadPool& pool) {
  for_blocks(J.layout(), Side::leaves, pool, [&](std::int64_t first, std::int64_t last) {
    block_kernels(J).transpose_multiply_leaves(J.view(), u, first, last, y);
  });
}

void transpose_multiply_hubs(const BlockJacobian& J, const double* u, const double* w, double* y,
                             ThreadPool& pool) {
  for_blocks(J.layout(), Side::hubs, pool, [&](std::int64_t first, std::int64_t last) {
    block_kernels(J).transpose_multiply_hubs(J.view(), u, w, first, last, y);
  });
}

void transpose_multiply(const BlockJacobian& J, const double* u, double* y, ThreadPool& pool) {
  double* of_leaves = y + J.layout().offset(Side::leaves);
  transpose_multiply_leaves(J, u, of_leaves, pool);
  transpose_multiply_hubs(J, u, of_leaves, y, pool);
}

}  // namespace raybundle::linalg
