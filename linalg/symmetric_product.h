#pragma once

#include <raybundle/linalg/kernels/dense_kernels.h>
#include <raybundle/linalg/large_vector.h>
#include <raybundle/linalg/parallel.h>
#include <raybundle/linalg/symmetric_blocks.h>

#include <vector>

namespace raybundle::linalg {

/// y = A x of symmetric blocks in sparse storage, in one pass over them: each piece of block rows
/// sums a part of its own, of rows and of columns, and the parts are added in their order.
class SymmetricProduct {
 public:
  /// `pattern` outlives it. `set` is meant for tests.
  explicit SymmetricProduct(const SymmetricPattern& pattern,
                            InstructionSet set = instruction_set());

  void multiply(const SymmetricBlocks& A, const double* x, double* y, ThreadPool& pool);

  /// Bytes of its parts.
  static double memory(const SymmetricPattern& pattern);

 private:
  /// Block rows [first, last), which touch the unknowns from `begin` on.
  struct Piece {
    std::int64_t first, last, begin;
    double* part;
  };
  void multiply_piece(const SymmetricBlocks& A, const double* x, std::int64_t at);

  const SymmetricPattern& pattern_;
  const DenseKernels& kernels_;
  std::vector<Piece> pieces_;
  std::int64_t longest_ = 0;     // scalars in a row
  LargeVector<double> parts_;    // piece by piece, from its `begin` on
  LargeVector<double> scratch_;  // two rows for each piece
};

}  // namespace raybundle::linalg
