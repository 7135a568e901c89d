#pragma once

#include <raybundle/linalg/block_layout.h>
#include <raybundle/linalg/kernels/kernel_table.h>
#include <raybundle/linalg/large_vector.h>
#include <raybundle/linalg/parallel.h>

#include <cstddef>

namespace raybundle::linalg {

/// The non-zero blocks of a Jacobian, row by row; the matrix itself is never formed. Rows are
/// rounded to a precision when they are stored; whatever is computed from them is summed in double.
class BlockJacobian {
 public:
  explicit BlockJacobian(const BlockLayout& block_layout,
                         Precision precision = Precision::double_precision);

  const BlockLayout& layout() const { return *layout_; }
  Precision precision() const { return precision_; }
  /// Room for the same rows in another precision; their values are lost.
  void set_precision(Precision precision);

  static double memory(const LayoutSize& n, Precision precision);

  /// What kernels take.
  JacobianView view() const;
  const void* blocks(Side side) const {
    return side == Side::hubs ? hub_blocks_.data() : leaf_blocks_.data();
  }

  /// One number: of residual r of a row, by unknown k of its block of a side.
  double at(Side side, std::int64_t row, int r, int k) const;
  void set(Side side, std::int64_t row, int r, int k, double value);

  LargeVector<double> anchor_blocks;  ///< Z: anchors x (leaf_size x hub_size), row-major

 private:
  std::int64_t place(Side side, std::int64_t row, int r, int k) const;

  const BlockLayout* layout_;  // outlives this
  Precision precision_ = Precision::double_precision;
  LargeVector<std::byte> hub_blocks_;   // rows x (row_size x hub_size); see in_pairs()
  LargeVector<std::byte> leaf_blocks_;  // rows x (row_size x leaf_size)
};

/// The kernels for a layout.
KernelShape kernel_shape(const BlockLayout& layout, Precision precision);
const BlockKernels& block_kernels(const BlockJacobian& J);

/// What kernels take. Who eliminates hubs adds their positions.
SideView side_view(const BlockLayout& layout, Side side);

/// u = J x; x has layout.unknowns() entries, u layout.residuals().
void multiply(const BlockJacobian& J, const double* x, double* u, ThreadPool& pool);

/// |J x|^2
double multiply_squares(const BlockJacobian& J, const double* x, ThreadPool& pool);

/// y = J^T u, all unknowns.
void transpose_multiply(const BlockJacobian& J, const double* u, double* y, ThreadPool& pool);

/// y = J_leaf^T u, the leaves alone.
void transpose_multiply_leaves(const BlockJacobian& J, const double* u, double* y,
                               ThreadPool& pool);
/// y = J_hub^T u + Z^T w by hub, with w given by leaf (not used without anchors): w = J_leaf^T u
/// makes it the hubs' part of J^T u.
void transpose_multiply_hubs(const BlockJacobian& J, const double* u, const double* w, double* y,
                             ThreadPool& pool);

/// Calls body(first, last) over the blocks of a side, in parallel.
template <class Body>
void for_blocks(const BlockLayout& layout, Side side, ThreadPool& pool, Body&& body) {
  // A hub has many rows, a leaf few: about the same work per piece.
  const std::int64_t grain = side == Side::hubs ? 1 : 128;
  parallel_for(pool, layout.block_count(side), grain, body);
}

}  // namespace raybundle::linalg
