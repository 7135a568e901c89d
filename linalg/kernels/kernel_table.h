#pragma once

#include <raybundle/linalg/precision.h>

#include <cstdint>

/// The inner loops of linalg, by block shape, precision and instruction set. A kernel works on a
/// range of blocks, which is also the grain of threading; nothing in it allocates or calls out.
///
/// The kernels of an elimination see the two sides of the normal equations as "kept" (k) and
/// "eliminated" (e), so that eliminating leaves or hubs is a choice of arguments. For an eliminated
/// block
///   M M^T = (H_ee + D_e)^-1,   q = M M^T g_e,
/// and with P = I - J_e M M^T J_e^T the reduced system is A = J_k^T P J_k + D_k, v = g_k - J_k^T
/// J_e q.
///
/// Anchored leaves are eliminated as l' = l + Z x, the step that their rows feel. Rows then have
/// one hub each, and anchors are left only in the damping |l|^2 = |l' - Z x|^2 of the leaves:
///   A = J_k^T J_k + Z^T D_e Z - W W^T + D_k,   W = (J_k^T J_e - Z^T D_e) M,
///   v = J_k^T r - (J_k^T J_e - Z^T D_e) q.
namespace raybundle::linalg {

/// Whether the block of a row is stored unknown by unknown instead of residual by residual. Vectors
/// that products read and write are then spread likewise, two numbers for one: x_i twice, and y_i
/// as the sum of two.
constexpr bool in_pairs(int row_size) { return row_size == 2; }
/// Numbers of one block in such a vector, which begin where a cache line does.
constexpr int operand_size(int row_size, int unknowns) {
  return in_pairs(row_size) ? (2 * unknowns + 7) / 8 * 8 : unknowns;
}

/// Sparsity from one side; see Incidence and BlockLayout. A null list or position is the identity,
/// null rows mean that coupling c is row c.
struct SideView {
  const std::int64_t* begin;
  const std::int32_t* list;
  const std::int32_t* position;
  const std::int32_t* block;
  const std::int64_t* rows;
};

/// Anchorage, and Z anchor by anchor (leaf x hub, row-major); all null when leaves have none.
struct AnchorView {
  const std::int64_t* begin;
  const std::int32_t* coupling;
  const std::int32_t* of_coupling;
  const double* Z;
};

/// The blocks of a Jacobian, row by row, of the numbers that the kernels are for; see in_pairs().
struct JacobianView {
  SideView hubs;
  SideView leaves;
  const void* J_hub;
  const void* J_leaf;
  AnchorView anchors;
};

/// A few rows as they were computed, on their way into a Jacobian: residuals, and blocks residual
/// by residual, all from row `first` on.
struct RowTile {
  std::int64_t first;
  std::int64_t last;
  double* residual;
  double* J_hub;
  double* J_leaf;
};
/// The most rows of a tile: with its normal equations it stays in the first-level cache.
constexpr std::int64_t tile_rows = 64;

/// Where normal equations go: J_leaf^T J_leaf by leaf (C), J^T r of the leaves, and sums by hub:
/// the diagonal of its block of J^T J, J_hub^T r and, with anchors, what they add to that.
struct NormalView {
  double* C;
  double* g_leaf;
  double* of_hubs;
};
/// How many rows of a hub those sums are.
constexpr int sums_of_hub(bool anchored) { return anchored ? 3 : 2; }

/// A symmetric block by its lower triangle, row by row, with rows as wide as vectors are.
constexpr int triangle_width(int size, int row) {
  const int vector = row < 4 ? 4 : 8;
  return row < vector && vector <= size ? vector : size;
}
constexpr int triangle_begin(int size, int row) {
  int begin = 0;
  for (int i = 0; i < row; ++i) begin += triangle_width(size, i);
  return begin;
}
constexpr int triangle_size(int size) { return triangle_begin(size, size); }

/// What one elimination works on: the Jacobian blocks of both sides, the damping of the eliminated
/// one, and the factors: M and q block by block, W coupling by coupling (eliminated x kept:
/// transposed), for the explicit matrix of anchored leaves alone.
struct EliminationView {
  SideView kept;
  SideView eliminated;
  const void* J_kept;
  const void* J_eliminated;
  const double* D;
  double* M;
  double* q;
  double* W;
  AnchorView anchors;
};

/// Where the blocks of one block row of a symmetric matrix go.
struct BlockRowView {
  double* values;               ///< of scalar row 0, column 0 of the diagonal block
  std::int64_t stride;          ///< between scalar rows
  const std::int32_t* slot_of;  ///< kept block -> position in the block row
};

/// A coarse space over the kept blocks: block k moves by P_k (kept x modes, row-major) times
/// what cluster[k] does. Block (g, h) of a pattern of clusters, of modes x modes numbers,
/// stands at the position of h in row g; g <= h, (g, g) comes first. The last three are scratch:
/// for each cluster -1; and room for the clusters of one eliminated block, coarse_numbers() each.
struct CoarseView {
  const std::int32_t* cluster;
  const double* P;
  const std::int64_t* row_begin;
  const std::int32_t* column;
  std::int32_t* place;
  std::int32_t* found;
  double* numbers;
};
/// In how many ways a cluster moves: one more than a kept block has unknowns.
constexpr int coarse_modes(int kept) { return kept + 1; }
constexpr int coarse_numbers(int kept, int eliminated) {
  return 2 * eliminated * coarse_modes(kept);
}

struct BlockKernels {
  /// u = J x for the rows of leaves [first, last).
  void (*multiply)(const JacobianView& J, const double* x_hub, const double* x_leaf,
                   std::int64_t first, std::int64_t last, double* u);
  /// |J x|^2 of the same rows.
  double (*squares)(const JacobianView& J, const double* x_hub, const double* x_leaf,
                    std::int64_t first, std::int64_t last);
  /// y = J_hub^T u + Z^T w for hubs [first, last), w by leaf; w is not read without anchors.
  void (*transpose_multiply_hubs)(const JacobianView& J, const double* u, const double* w,
                                  std::int64_t first, std::int64_t last, double* y);
  /// y = J_leaf^T u for leaves [first, last).
  void (*transpose_multiply_leaves)(const JacobianView& J, const double* u, std::int64_t first,
                                    std::int64_t last, double* y);
  /// Stores the rows of a tile, those of leaves [first, last) or some of a single one, and sums
  /// what they are worth in the normal equations: gradients of the rows as computed, squares of
  /// the rows as stored. C and g_leaf start with a leaf's first row; sums by hub go on.
  void (*absorb)(const JacobianView& J, const RowTile& tile, std::int64_t first, std::int64_t last,
                 const NormalView& normal);
  /// The diagonal blocks of J^T J of hubs [first, last), anchors included; C by leaf is not read
  /// without them.
  void (*hub_squares)(const JacobianView& J, const double* C, std::int64_t first, std::int64_t last,
                      double* H);
};

struct EliminationKernels {
  /// M of blocks [first, last) from H + diag(d) by Cholesky. A block with a pivot not above
  /// `tolerance` times its diagonal entry is left and its index put into `failed`; returns their
  /// number.
  std::int64_t (*factor)(const double* H, const double* d, double tolerance, std::int64_t first,
                         std::int64_t last, double* M, std::int64_t* failed);
  /// Writes q of eliminated [first, last).
  void (*solve_own)(const EliminationView& view, const double* g_eliminated, std::int64_t first,
                    std::int64_t last);
  /// Writes W of eliminated [first, last); of anchored leaves alone.
  void (*couple)(const EliminationView& view, std::int64_t first, std::int64_t last);
  /// v_a += (v - g_k)_a, for kept a in [first, last).
  void (*reduce_gradient)(const EliminationView& view, std::int64_t first, std::int64_t last,
                          double* v);
  /// u = P J_k x of the rows of eliminated [first, last); not for anchored leaves.
  void (*project)(const EliminationView& view, const double* x_kept, std::int64_t first,
                  std::int64_t last, double* u);
  /// y += (A - D_k) x as far as it is by the rows of eliminated [first, last), all kept blocks: x
  /// and y as operands, see in_pairs(). `u` is scratch for the residuals of one of them.
  void (*multiply)(const EliminationView& view, const double* x, std::int64_t first,
                   std::int64_t last, double* u, double* y);
  /// x_e = -(q + M M^T J_e^T J_k x_k), with anchors -(q + M M^T (J_e^T J_k - D Z) x_k) - Z x_k, for
  /// eliminated [first, last); returns |J x|^2 of their rows. `u` as above.
  double (*back_substitute)(const EliminationView& view, const double* x_kept, std::int64_t first,
                            std::int64_t last, double* u, double* x_eliminated);
  /// A_ab += J_a^T P_ab J_b, with anchors J_a^T J_b + Z_a^T D Z_b - W_a W_b^T, for all b >= a, into
  /// the block row of kept a, and v_a as reduce_gradient does.
  void (*add_products)(const EliminationView& view, std::int64_t a, const BlockRowView& row,
                       double* v);
  /// What the rows of eliminated [first, last) add to A_aa and v_a, for all kept a: `sums` has by
  /// kept block a triangle, then a row.
  void (*add_diagonal)(const EliminationView& view, std::int64_t first, std::int64_t last,
                       double* sums);
  /// A_aa without its damping, for kept [first, last).
  void (*diagonal_blocks)(const EliminationView& view, std::int64_t first, std::int64_t last,
                          double* A_diagonal);
  /// The block J_k^T J_e of coupling c, kept x eliminated, with `stride` between its rows.
  void (*coupling)(const EliminationView& view, std::int64_t c, double* E, std::int64_t stride);
  /// What the rows of eliminated [first, last) add to P^T A P, whose blocks are `values`. Null
  /// where the kept blocks are the smaller ones: leaves make no coarse space.
  void (*coarse_products)(const EliminationView& view, const CoarseView& coarse, std::int64_t first,
                          std::int64_t last, double* values);
};

/// What a kernel is made for.
struct KernelShape {
  Precision precision;
  bool anchored;
  int row;
  int hub;
  int leaf;
};

/// The kernels for a layout; both throw std::invalid_argument for shapes nobody compiled.
const BlockKernels& block_kernels(const KernelShape& shape);
/// Those that eliminate the leaves or the hubs. Hubs that anchor leaves cannot be eliminated.
const EliminationKernels& elimination_kernels(const KernelShape& shape, bool eliminate_leaves);

}  // namespace raybundle::linalg
