#include <raybundle/linalg/block_jacobian.h>

namespace raybundle::linalg {
namespace {

RowShape row_shape(const BlockLayout& layout) {
  return layout.several_parts() ? RowShape::several_parts : RowShape::one_part;
}

template <class T>
const T* data_or_null(const std::vector<T>& list) {
  return list.empty() ? nullptr : list.data();
}

PartsView parts_view(const RowParts& parts) {
  return {
      data_or_null(parts.leaf_rows), data_or_null(parts.row_parts),      data_or_null(parts.row),
      data_or_null(parts.hub),       data_or_null(parts.coupling_begin), data_or_null(parts.list)};
}

}  // namespace

BlockJacobian::BlockJacobian(const BlockLayout& block_layout)
    : layout(&block_layout),
      hub_blocks(index(layout->part_count() * layout->row_size * layout->hub_size)),
      leaf_blocks(index(layout->residuals() * layout->leaf_size)) {}

const BlockKernels& block_kernels(const BlockLayout& layout) {
  return block_kernels(row_shape(layout), layout.row_size, layout.hub_size, layout.leaf_size);
}

const EliminationKernels& elimination_kernels(const BlockLayout& layout, Side eliminated) {
  return elimination_kernels(row_shape(layout), layout.row_size,
                             layout.block_size(opposite(eliminated)),
                             layout.block_size(eliminated));
}

SideView side_view(const BlockLayout& layout, Side side) {
  const Incidence& incidence = layout.incidence(side);
  return {
      incidence.begin.data(), data_or_null(incidence.list),       data_or_null(incidence.position),
      incidence.block.data(), data_or_null(layout.coupling_rows), parts_view(layout.parts)};
}

void multiply(const BlockJacobian& J, const double* x, double* u, ThreadPool& pool) {
  const BlockLayout& layout = *J.layout;
  const SideView hubs = side_view(layout, Side::hubs);
  const SideView leaves = side_view(layout, Side::leaves);
  const double* x_leaf = x + layout.offset(Side::leaves);
  for_blocks(layout, Side::leaves, pool, [&](std::int64_t first, std::int64_t last) {
    block_kernels(layout).multiply(leaves, hubs, J.hub_blocks.data(), J.leaf_blocks.data(), x,
                                   x_leaf, first, last, u);
  });
}

void transpose_multiply(const BlockJacobian& J, Side side, const double* u, double* y,
                        ThreadPool& pool) {
  const BlockLayout& layout = *J.layout;
  const SideView view = side_view(layout, side);
  const BlockKernels& kernels = block_kernels(layout);
  const auto kernel =
      side == Side::hubs ? kernels.transpose_multiply_hubs : kernels.transpose_multiply_leaves;
  for_blocks(layout, side, pool, [&](std::int64_t first, std::int64_t last) {
    kernel(view, J.blocks(side), u, first, last, y);
  });
}

void transpose_multiply(const BlockJacobian& J, const double* u, double* y, ThreadPool& pool) {
  transpose_multiply(J, Side::hubs, u, y, pool);
  transpose_multiply(J, Side::leaves, u, y + J.layout->offset(Side::leaves), pool);
}

}  // namespace raybundle::linalg
