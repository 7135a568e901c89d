#pragma once

#include <raybundle/linalg/ordering.h>
#include <raybundle/linalg/symmetric_blocks.h>

#include <memory>
#include <vector>

namespace raybundle::linalg {

/// Supernodal Cholesky by CHOLMOD [Chen08] with 64-bit indices; analysed once, factorised often.
class CholmodCholesky {
 public:
  /// `pattern` outlives this. Throws std::bad_alloc, before the factor is allocated where its
  /// exact size is known to be too large.
  CholmodCholesky(const SymmetricPattern& pattern, const Ordering& ordering);
  ~CholmodCholesky();
  CholmodCholesky(const CholmodCholesky&) = delete;
  CholmodCholesky& operator=(const CholmodCholesky&) = delete;

  /// Bytes that matrix, analysis and factor take, as predicted.
  static double memory(const SymmetricPattern& pattern, const Ordering& ordering);

  /// `A` in sparse storage. False when it is not positive definite to working precision: the
  /// pivot of column k must be larger than n eps a_kk, as for DenseCholesky.
  bool factor(const SymmetricBlocks& A);
  void solve(double* x);

 private:
  bool pivots_are_sound(const SymmetricBlocks& A) const;

  struct Cholmod;
  std::unique_ptr<Cholmod> cholmod_;
};

}  // namespace raybundle::linalg
