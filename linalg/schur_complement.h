#pragma once

#include <raybundle/linalg/reduced_system.h>

namespace raybundle::linalg {

/// The reduced system after eliminating one side. With k the kept and e the eliminated side and
/// M M^T = (H_ee + D_e)^-1 block by block,
///   A = J_k^T P J_k + D_k,  v = J_k^T P r,  P = I - J_e M M^T J_e^T,
/// which the implicit product uses as it stands; the explicit matrix is summed from the coupling
/// blocks W = E M: A = H_kk + D_k - W W^T.
class SchurComplement final : public ReducedSystem {
 public:
  SchurComplement(const BlockLayout& layout, Side eliminated, ThreadPool& pool);

  std::int64_t size() const override { return layout_.size(kept_); }
  std::int64_t offset() const override { return layout_.offset(kept_); }
  void prepare(const Linearization& at, const double* damping) override;
  void gradient(double* v) override;
  void apply(const double* x, double* y) override;
  SymmetricPattern pattern() const override;
  void assemble(SymmetricBlocks& A, double* v) override;
  void expand(const double* x, double* step) override;
  void diagonal_blocks(Blocks which, DiagonalBlocks& out) override;

  /// Eliminated blocks that Cholesky refused in the last prepare().
  std::int64_t deficient_blocks() const { return deficient_blocks_; }

 private:
  EliminationView view() const;
  void factor();
  void factor_deficient(const std::vector<std::int64_t>& blocks);
  void couple();
  std::vector<std::int32_t> neighbours(std::int64_t a, std::vector<std::int64_t>& seen) const;
  void start_row(SymmetricBlocks& A, std::int64_t a, double* v) const;
  const double* damping(Side side) const { return damping_ + layout_.offset(side); }

  const BlockLayout& layout_;
  ThreadPool& pool_;
  Side kept_;
  Side eliminated_;
  const EliminationKernels& kernels_;
  Linearization at_ = {};
  const double* damping_ = nullptr;
  std::vector<double> M_;                ///< factors of the eliminated blocks
  std::vector<double> W_;                ///< coupling blocks, allocated by the first assemble()
  std::vector<double> y_;                ///< M^T g_e
  std::vector<double> rows_;             ///< scratch, one number per residual
  std::vector<std::int32_t> slot_;       ///< per piece of work: kept block -> slot in a block row
  std::int64_t deficient_blocks_ = 0;
};

}  // namespace raybundle::linalg
