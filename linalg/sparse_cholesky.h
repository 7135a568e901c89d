#pragma once

#include <raybundle/linalg/ordering.h>
#include <raybundle/linalg/symmetric_blocks.h>

#include <memory>
#include <vector>

namespace raybundle::linalg {

/// Supernodal Cholesky by CHOLMOD [Chen08] with 64-bit indices; analysed once, factorised often.
class SparseCholesky {
 public:
  /// `pattern` outlives this. Throws std::bad_alloc.
  SparseCholesky(const SymmetricPattern& pattern, const Ordering& ordering);
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  /// `A` in sparse storage. False when it is not positive definite.
  bool factor(const SymmetricBlocks& A);
  void solve(double* x);

 private:
  struct Cholmod;
  std::unique_ptr<Cholmod> cholmod_;
};

}  // namespace raybundle::linalg
