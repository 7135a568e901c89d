#pragma once

#include <raybundle/linalg/ordering.h>
#include <raybundle/linalg/parallel.h>
#include <raybundle/linalg/symmetric_blocks.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace raybundle::linalg {

/// How to factorise a matrix of some sparsity.
struct CholeskyPlan {
  SymmetricPattern pattern;
  SymmetricBlocks::Storage storage = SymmetricBlocks::Storage::dense;
  Ordering ordering = {};  ///< of sparse storage
  double memory = 0;       ///< bytes that the matrix and its factor take
  double work = 0;  ///< predicted multiplications of one factorisation, as fast as dense ones
};

/// Dense or sparse storage as asked for, else whichever the predicted work favours. Throws
/// std::bad_alloc when the matrix or its factor cannot be held.
CholeskyPlan plan_cholesky(SymmetricPattern pattern,
                           std::optional<SymmetricBlocks::Storage> storage = std::nullopt);

/// Cholesky factorisation of a symmetric block matrix whose sparsity never changes: ordering and
/// analysis once, factorisation often.
class Cholesky {
 public:
  using Storage = SymmetricBlocks::Storage;
  virtual ~Cholesky() = default;

  /// Where the caller writes the matrix before factor(). Its values are undefined afterwards.
  SymmetricBlocks& matrix() { return matrix_; }
  const SymmetricBlocks& matrix() const { return matrix_; }

  /// False when the matrix is not positive definite or not finite.
  virtual bool factor() = 0;
  /// Solves A x = b in place, after a successful factor().
  virtual void solve(double* x) = 0;
  /// What does the work, for people: "dense, order 441" or "sparse, nested dissection, ...".
  virtual std::string description() const = 0;

  /// `pool` outlives it. Throws std::bad_alloc when the matrix or its factor cannot be held.
  static std::unique_ptr<Cholesky> make(CholeskyPlan plan, ThreadPool& pool);

 protected:
  Cholesky(SymmetricPattern pattern, Storage storage) : matrix_(std::move(pattern), storage) {}

 private:
  SymmetricBlocks matrix_;
};

}  // namespace raybundle::linalg
