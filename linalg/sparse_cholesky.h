#pragma once

#include <raybundle/linalg/symmetric_blocks.h>

#include <memory>
#include <string>

namespace raybundle::linalg {

/// Supernodal Cholesky by CHOLMOD [Chen08] with 64-bit indices. The ordering is found on the block
/// graph, by minimum degree and by nested dissection, and the one with less predicted fill is kept.
class SparseCholesky {
 public:
  explicit SparseCholesky(const SymmetricPattern& pattern);
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  /// Work of one factorisation in flops, and numbers in the factor, as predicted on the blocks.
  double predicted_flops() const;
  double predicted_nonzeros() const;

  /// Analyses the scalar matrix; needed once before factor(), after the choice for this solver.
  void analyze();
  bool factor(const SymmetricBlocks& A);
  void solve(double* x);

  const std::string& ordering() const;  ///< "minimum degree" or "nested dissection"

 private:
  struct Cholmod;
  std::unique_ptr<Cholmod> cholmod_;
};

}  // namespace raybundle::linalg
