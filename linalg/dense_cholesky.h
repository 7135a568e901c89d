#pragma once

#include <cstdint>

#include <raybundle/linalg/large_vector.h>
#include <raybundle/linalg/tiled_cholesky.h>

namespace raybundle::linalg {

/// Cholesky factorisation A = L L^T of dense symmetric positive definite matrices of one order,
/// independent of any BLAS.
///
/// A is n x n, column-major with leading dimension ld >= n; only its lower triangle is read and
/// written (a row-major upper triangle is the same memory). The result has the same bits for any
/// number of threads. The object owns a workspace of about n^2 / 2 numbers, allocated once; use it
/// from one thread at a time.
class DenseCholesky {
 public:
  /// For matrices of `order` >= 0. `set` is meant for tests and measurements; sets that the library
  /// was not built for are replaced by the next lower one. Throws std::bad_alloc.
  explicit DenseCholesky(std::int64_t order, InstructionSet set = instruction_set());

  std::int64_t order() const { return order_; }

  /// Bytes that factorising a matrix of this order takes, the matrix itself included.
  static double memory(std::int64_t order) {
    const auto n = static_cast<double>(order);
    return 12 * n * n;
  }

  /// The instruction set in use.
  InstructionSet instructions() const { return kernels_->set; }

  /// Replaces the lower triangle of A by L. False, with unspecified content, when A is not positive
  /// definite to working precision or not finite: the pivot of column k must be larger than
  /// n eps a_kk, below which it may be nothing but rounding error, and a normal number. The test
  /// does not depend on how rows and columns are scaled.
  bool factor(double* A, std::int64_t ld, ThreadPool& pool);

  /// b <- (L L^T)^-1 b for the n numbers b and the L that `factor` left in A.
  void solve(const double* A, std::int64_t ld, double* b) const;

 private:
  void set_thresholds(const double* A, std::int64_t ld);

  std::int64_t order_;
  const DenseKernels* kernels_;
  std::int64_t strips_;
  LargeVector<double> packed_, inverse_diagonal_, threshold_;
  PackedTriangle triangle_;
  TiledCholesky tiled_;
};

}  // namespace raybundle::linalg
