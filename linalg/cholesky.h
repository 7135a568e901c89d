#pragma once

#include <raybundle/linalg/parallel.h>
#include <raybundle/linalg/symmetric_blocks.h>

#include <memory>
#include <optional>
#include <string>

namespace raybundle::linalg {

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

  /// Dense or sparse as asked for, else whichever the predicted work favours. `pool` outlives it.
  /// Throws std::bad_alloc when the matrix or its factor cannot be held.
  static std::unique_ptr<Cholesky> make(SymmetricPattern pattern, std::optional<Storage> storage,
                                        ThreadPool& pool);

 protected:
  Cholesky(SymmetricPattern pattern, Storage storage) : matrix_(std::move(pattern), storage) {}

 private:
  SymmetricBlocks matrix_;
};

}  // namespace raybundle::linalg
