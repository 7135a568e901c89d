#pragma once

#include <raybundle/linalg/reduced_system.h>
#include <raybundle/linalg/symmetric_product.h>

#include <memory>
#include <vector>

namespace raybundle::linalg {

/// A reduced system whose matrix is formed once per linearisation and damping, so that a product
/// reads the matrix and not the Jacobian: less work where products are many and the matrix is
/// sparse.
class ExplicitSystem final : public ReducedSystem {
 public:
  /// `pattern` is that of `system`; `pool` outlives this. Throws MemoryRefusal when there is no
  /// room for the matrix.
  ExplicitSystem(std::unique_ptr<ReducedSystem> system, SymmetricPattern pattern, ThreadPool& pool);

  /// Bytes of the matrix and what its product needs.
  static double memory(const SymmetricPattern& pattern);

  std::int64_t size() const override { return system_->size(); }
  std::int64_t offset() const override { return system_->offset(); }
  void prepare(const Linearization& at, const double* damping) override;
  void gradient(double* v) override;
  void apply(const double* x, double* y) override;
  SymmetricPattern pattern() const override { return A_.pattern(); }
  void assemble(SymmetricBlocks& A, double* v) override { system_->assemble(A, v); }
  double expand(const double* x, double* step) override { return system_->expand(x, step); }
  void diagonal_blocks(DiagonalBlocks& out) override { system_->diagonal_blocks(out); }
  void reduced_diagonal(DiagonalBlocks& out, double* v) override;
  const double* coarse_matrix(const CoarseBasis& basis) override {
    return system_->coarse_matrix(basis);
  }

 private:
  std::unique_ptr<ReducedSystem> system_;
  ThreadPool& pool_;
  SymmetricBlocks A_;
  SymmetricProduct product_;
  std::vector<double> v_;
};

}  // namespace raybundle::linalg
