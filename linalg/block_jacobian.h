#pragma once

#include <raybundle/linalg/block_layout.h>
#include <raybundle/linalg/kernels/kernel_table.h>
#include <raybundle/linalg/large_vector.h>
#include <raybundle/linalg/parallel.h>

namespace raybundle::linalg {

/// The non-zero blocks of a Jacobian, row by row; the matrix itself is never formed.
struct BlockJacobian {
  explicit BlockJacobian(const BlockLayout& block_layout);
  static double memory(const LayoutSize& n);

  const BlockLayout* layout;          ///< outlives this
  LargeVector<double> hub_blocks;     ///< rows x (row_size x hub_size), row-major
  LargeVector<double> leaf_blocks;    ///< rows x (row_size x leaf_size), row-major
  LargeVector<double> anchor_blocks;  ///< Z: anchors x (leaf_size x hub_size), row-major

  const double* blocks(Side side) const {
    return side == Side::hubs ? hub_blocks.data() : leaf_blocks.data();
  }
};

/// The kernels for a layout.
const BlockKernels& block_kernels(const BlockLayout& layout);
const EliminationKernels& elimination_kernels(const BlockLayout& layout, Side eliminated);

/// What kernels take. Who eliminates hubs adds their positions.
SideView side_view(const BlockLayout& layout, Side side);
AnchorView anchor_view(const BlockJacobian& J);
JacobianView view(const BlockJacobian& J);

/// u = J x; x has layout.unknowns() entries, u layout.residuals().
void multiply(const BlockJacobian& J, const double* x, double* u, ThreadPool& pool);

/// The same, and |u|^2.
double multiply_squares(const BlockJacobian& J, const double* x, double* u, ThreadPool& pool);

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
