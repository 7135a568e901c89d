#pragma once

#include <raybundle/linalg/hub_sums.h>
#include <raybundle/linalg/large_vector.h>
#include <raybundle/linalg/reduced_system.h>

namespace raybundle::linalg {

/// What a pass over the leaves for a coarse matrix takes, by piece of work.
struct CoarseScratch {
  std::vector<std::int32_t> place;  // of each cluster
  std::vector<std::int32_t> found;
  std::vector<double> numbers;
};

/// The reduced system after eliminating one side. With k the kept and e the eliminated side,
/// M M^T = (H_ee + D_e)^-1 block by block and q = M M^T g_e,
///   A = J_k^T P J_k + D_k,  P = I - J_e M M^T J_e^T,  v = g_k - J_k^T J_e q,
/// for the implicit product as for the explicit matrix. The coupling blocks of E are never stored:
/// rows of J do for them, and but for M and q nothing is kept. Hubs that anchor leaves cannot be
/// eliminated, their block of H not being block diagonal. Anchored leaves are eliminated as
/// kernel_table.h says, with W by coupling for the explicit matrix.
class SchurComplement final : public ReducedSystem {
 public:
  /// Throws std::invalid_argument for hubs to be eliminated that are anchors.
  SchurComplement(const BlockLayout& layout, Side eliminated, ThreadPool& pool);

  /// Bytes, for products or for explicit matrices alone.
  static double memory(const LayoutSize& n, Side eliminated, bool assembled);

  std::int64_t size() const override { return layout_.size(kept_); }
  std::int64_t offset() const override { return layout_.offset(kept_); }
  void prepare(const Linearization& at, const double* damping) override;
  void gradient(double* v) override;
  void apply(const double* x, double* y) override;
  SymmetricPattern pattern() const override;
  void assemble(SymmetricBlocks& A, double* v) override;
  double expand(const double* x, double* step) override;
  void diagonal_blocks(DiagonalBlocks& out) override;
  void reduced_diagonal(DiagonalBlocks& out, double* v) override;
  const double* coarse_matrix(const CoarseBasis& basis) override;
  /// Bytes of that.
  static double coarse_memory(const BlockLayout& layout, const CoarseBasis& basis);

  /// Eliminated blocks that Cholesky refused in the last prepare().
  std::int64_t deficient_blocks() const { return deficient_blocks_; }

 private:
  EliminationView view();
  const EliminationKernels& kernels() const;
  const double* own_gradient() const;
  const double* eliminated_blocks() const;
  void factor();
  void factor_deficient(const std::vector<std::int64_t>& blocks);
  void apply_to_hubs(const double* x, double* y);
  template <class Update>
  void for_hubs(Update&& update);
  void apply_to_leaves(const double* x, double* y);
  double* scratch(std::int64_t piece) { return scratch_.data() + piece * most_residuals_; }
  void reduced_diagonal_of_hubs(double* A, double* v);
  CoarseView coarse_view(const CoarseBasis& basis, std::int64_t piece);
  void add_coarse_damping(const CoarseBasis& basis, double* values) const;
  void start_diagonal(DiagonalBlocks& out) const;
  void damp_diagonal(DiagonalBlocks& out) const;
  void start_row(SymmetricBlocks& A, std::int64_t a, double* v) const;
  const double* damping(Side side) const { return damping_ + layout_.offset(side); }

  const BlockLayout& layout_;
  ThreadPool& pool_;
  Side kept_;
  Side eliminated_;
  Linearization at_ = {};
  const double* damping_ = nullptr;
  LargeVector<double> M_;           // block by block
  LargeVector<double> q_;           // block by block
  LargeVector<double> W_;           // coupling by coupling; of anchored leaves, for assemble()
  LargeVector<double> operand_;     // x of apply_to_hubs(), spread
  LargeVector<double> rows_;        // scratch of apply_to_leaves(), one number per residual
  HubSums product_sums_;            // of apply_to_hubs()
  HubSums diagonal_sums_;           // of reduced_diagonal_of_hubs()
  HubSums coarse_sums_;             // of coarse_matrix()
  CoarseScratch coarse_scratch_;    // likewise
  std::vector<double> hub_blocks_;  // of H, where hubs are eliminated
  LargeVector<std::int32_t> hub_positions_;  // likewise
  std::int64_t most_residuals_ = 0;          // of an eliminated block
  LargeVector<double> scratch_;              // for the residuals of one, by piece of work
  std::vector<std::int32_t> slot_;           // per piece of work: kept block -> slot in a block row
  std::int64_t deficient_blocks_ = 0;
};

}  // namespace raybundle::linalg
