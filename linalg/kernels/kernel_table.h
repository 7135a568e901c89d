#pragma once

#include <cstdint>

/// The inner loops of linalg, by block shape and instruction set. A kernel works on a range of
/// blocks, which is also the grain of threading; nothing in it allocates or calls out.
///
/// Every kernel sees the two sides of the normal equations as "kept" (k) and "eliminated" (e), so
/// that eliminating leaves or hubs is a choice of arguments. M_e with M_e M_e^T = (H_ee + D)^-1 is
/// the factor of an eliminated block.
namespace raybundle::linalg {

/// Sparsity from one side; see Incidence and BlockLayout. A null list or position is the identity,
/// null rows mean that coupling c is row c.
struct SideView {
  const std::int64_t* begin;
  const std::int64_t* list;
  const std::int64_t* position;
  const std::int32_t* block;
  const std::int64_t* rows;
};

/// What one elimination works on: the Jacobian blocks of both sides (row-major, row by row), the
/// residuals, and the factors M (block by block, row-major).
struct EliminationView {
  SideView kept;
  SideView eliminated;
  const double* J_kept;
  const double* J_eliminated;
  const double* M;
};

/// Where the blocks of one block row of a symmetric matrix go.
struct BlockRowView {
  double* values;               ///< of scalar row 0, column 0 of the diagonal block
  std::int64_t stride;          ///< between scalar rows
  const std::int32_t* slot_of;  ///< kept block -> position in the block row
};

struct BlockKernels {
  /// u = J_hub x_hub + J_leaf x_leaf for the rows of leaves [first, last).
  void (*multiply)(const SideView& leaves, const SideView& hubs, const double* J_hub,
                   const double* J_leaf, const double* x_hub, const double* x_leaf,
                   std::int64_t first, std::int64_t last, double* u);
  /// y_b = J_b^T u for the hubs (leaves) [first, last).
  void (*transpose_multiply_hubs)(const SideView& side, const double* J, const double* u,
                                  std::int64_t first, std::int64_t last, double* y);
  void (*transpose_multiply_leaves)(const SideView& side, const double* J, const double* u,
                                    std::int64_t first, std::int64_t last, double* y);
  /// H_b = J_b^T J_b (full symmetric) and g_b = J_b^T r for the hubs (leaves) [first, last).
  void (*normal_blocks_hubs)(const SideView& side, const double* J, const double* r,
                             std::int64_t first, std::int64_t last, double* H, double* g);
  void (*normal_blocks_leaves)(const SideView& side, const double* J, const double* r,
                               std::int64_t first, std::int64_t last, double* H, double* g);
};

struct EliminationKernels {
  /// M of blocks [first, last) from H + diag(d) by Cholesky; a block with a pivot not above
  /// `tolerance` times its diagonal entry is left and its index put into `failed`; returns how many.
  std::int64_t (*factor)(const double* H, const double* d, double tolerance, std::int64_t first,
                         std::int64_t last, double* M, std::int64_t* failed);
  /// W_c^T = M_e^T J_e^T J_k (eliminated x kept) for the couplings of eliminated [first, last),
  /// and y_e = M_e^T g_e.
  void (*couple)(const EliminationView& view, const double* g_eliminated, std::int64_t first,
                 std::int64_t last, double* W, double* y);
  /// u := u + J_k x_k (x_k may be null), then u := u - J_e M M^T J_e^T u, for the rows of
  /// eliminated [first, last). With reset, u starts at zero.
  void (*project)(const EliminationView& view, const double* x_kept, bool reset,
                  std::int64_t first, std::int64_t last, double* u);
  /// x_e = -M M^T (g_e + J_e^T J_k x_k) for eliminated [first, last).
  void (*back_substitute)(const EliminationView& view, const double* g_eliminated,
                          const double* x_kept, std::int64_t first, std::int64_t last,
                          double* x_eliminated);
  /// S_ab -= W_c W_c'^T for all b >= a, into the block row of kept a, and v_a -= W_c y_e.
  void (*subtract_products)(const EliminationView& view, const double* W, const double* y,
                            std::int64_t a, const BlockRowView& row, double* v);
  /// S_aa = H_aa - sum_c W_c W_c^T without stored W, for kept [first, last).
  void (*diagonal_blocks)(const EliminationView& view, const double* H_kept, std::int64_t first,
                          std::int64_t last, double* S_diagonal);
};

/// The kernels for a layout; throws std::invalid_argument for block sizes nobody compiled.
const BlockKernels& block_kernels(int row_size, int hub_size, int leaf_size);
/// The kernels that keep blocks of `kept` and eliminate blocks of `eliminated` unknowns.
const EliminationKernels& elimination_kernels(int row_size, int kept, int eliminated);

}  // namespace raybundle::linalg
