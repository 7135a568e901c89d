#pragma once

#include <raybundle/linalg/ordering.h>
#include <raybundle/linalg/parallel.h>
#include <raybundle/linalg/supernodes.h>
#include <raybundle/linalg/symmetric_blocks.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace raybundle::linalg {

/// Who factorises: our own code for dense matrices, or for sparse ones, or CHOLMOD.
enum class CholeskyKind { dense, sparse, cholmod };

/// How to factorise a matrix of some sparsity, and what that takes.
struct CholeskyPlan {
  SymmetricPattern pattern;
  CholeskyKind kind = CholeskyKind::dense;
  Ordering ordering = {};      ///< where it is not dense
  Supernodes supernodes = {};  ///< where it is sparse
  double work = 0;    ///< predicted multiplications of one factorisation, as fast as dense ones
  double memory = 0;  ///< predicted bytes, the matrix itself included
  double sparse_memory = 0;  ///< the same of our sparse factorisation, where it was thought of
};

/// Of the kind asked for, else dense or sparse, whichever is less work. Nothing is refused here.
CholeskyPlan plan_cholesky(SymmetricPattern pattern, int threads,
                           std::optional<CholeskyKind> kind = std::nullopt);

/// Cholesky factorisation of a symmetric block matrix whose sparsity never changes: ordering and
/// analysis once, factorisation often.
class Cholesky {
 public:
  virtual ~Cholesky() = default;

  /// Where the caller writes the matrix before factor(). Its values are undefined afterwards.
  SymmetricBlocks& matrix() { return matrix_; }
  const SymmetricBlocks& matrix() const { return matrix_; }

  /// False when the matrix is not positive definite or not finite.
  virtual bool factor() = 0;
  /// Solves A x = b in place, after a successful factor().
  virtual void solve(double* x) = 0;
  virtual CholeskyKind kind() const = 0;
  /// What does the work, for people.
  virtual std::string description() const = 0;

  /// `pool` outlives it. Throws MemoryRefusal when there is less memory than planned.
  static std::unique_ptr<Cholesky> make(CholeskyPlan plan, ThreadPool& pool);

 protected:
  Cholesky(SymmetricPattern pattern, SymmetricBlocks::Storage storage)
      : matrix_(std::move(pattern), storage) {}

 private:
  SymmetricBlocks matrix_;
};

}  // namespace raybundle::linalg
