#pragma once

#include <cstdint>

/// The inner loops of linalg, by block shape and instruction set. A kernel works on a range of
/// blocks, which is also the grain of threading; nothing in it allocates or calls out.
///
/// Every kernel sees the two sides of the normal equations as "kept" (k) and "eliminated" (e), so
/// that eliminating leaves or hubs is a choice of arguments. For an eliminated block
///   M M^T = (H_ee + D_e)^-1,   U = J_e M,   y = M^T g_e,
/// and with P = I - U U^T the reduced system is A = J_k^T P J_k + D_k, v = g_k - J_k^T U y.
/// Where rows have several parts, leaves alone are eliminated, and W = J_k^T U by coupling.
namespace raybundle::linalg {

/// RowParts as kernels take them; all null when a row is its own part.
struct PartsView {
  const std::int64_t* leaf_rows;
  const std::int64_t* row_parts;
  const std::int64_t* row;
  const std::int32_t* hub;
  const std::int64_t* coupling_begin;
  const std::int64_t* list;
};

/// Sparsity from one side; see Incidence and BlockLayout. A null list or position is the identity,
/// null rows mean that coupling c is row c.
struct SideView {
  const std::int64_t* begin;
  const std::int64_t* list;
  const std::int64_t* position;
  const std::int32_t* block;
  const std::int64_t* rows;
  PartsView parts;
};

/// What one elimination works on: the Jacobian blocks of both sides (row-major; of hubs part by
/// part, of leaves row by row), and the factors: M and y block by block, U row by row, as J_e, W
/// coupling by coupling (kept x eliminated).
struct EliminationView {
  SideView kept;
  SideView eliminated;
  const double* J_kept;
  const double* J_eliminated;
  double* M;
  double* U;
  double* y;
  double* W;
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
  /// M of blocks [first, last) from H + diag(d) by Cholesky. A block with a pivot not above
  /// `tolerance` times its diagonal entry is left and its index put into `failed`; returns their
  /// number.
  std::int64_t (*factor)(const double* H, const double* d, double tolerance, std::int64_t first,
                         std::int64_t last, double* M, std::int64_t* failed);
  /// Writes U and y, and W where rows have several parts, of eliminated [first, last).
  void (*transform)(const EliminationView& view, const double* g_eliminated, std::int64_t first,
                    std::int64_t last);
  /// v_a -= J_a^T U y for kept a in [first, last).
  void (*reduce_gradient)(const EliminationView& view, std::int64_t first, std::int64_t last,
                          double* v);
  /// u = P J_k x for the rows of eliminated [first, last).
  void (*project)(const EliminationView& view, const double* x_kept, std::int64_t first,
                  std::int64_t last, double* u);
  /// x_e = -M (y + U^T J_k x_k) for eliminated [first, last).
  void (*back_substitute)(const EliminationView& view, const double* x_kept, std::int64_t first,
                          std::int64_t last, double* x_eliminated);
  /// A_ab -= J_a^T U U^T J_b for all b >= a, into the block row of kept a, and v_a -= J_a^T U y.
  void (*subtract_products)(const EliminationView& view, std::int64_t a, const BlockRowView& row,
                            double* v);
  /// A_ab += J_a^T J_b for all b > a: what two parts of a row have in common. Null when rows have
  /// one.
  void (*add_products)(const EliminationView& view, std::int64_t a, const BlockRowView& row);
  /// A_aa = H_aa - J_a^T U U^T J_a for kept [first, last).
  void (*diagonal_blocks)(const EliminationView& view, const double* H_kept, std::int64_t first,
                          std::int64_t last, double* A_diagonal);
  /// The block J_k^T J_e of coupling c, kept x eliminated, with `stride` between its rows.
  void (*coupling)(const EliminationView& view, std::int64_t c, double* E, std::int64_t stride);
};

enum class RowShape { one_part, several_parts };

/// The kernels for a layout; throws std::invalid_argument for block sizes nobody compiled.
const BlockKernels& block_kernels(RowShape shape, int row_size, int hub_size, int leaf_size);
/// The kernels that keep blocks of `kept` and eliminate blocks of `eliminated` unknowns.
const EliminationKernels& elimination_kernels(RowShape shape, int row_size, int kept,
                                              int eliminated);

}  // namespace raybundle::linalg
