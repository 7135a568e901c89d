#pragma once

#include <raybundle/linalg/cholesky.h>
#include <raybundle/linalg/reduced_system.h>

#include <memory>
#include <vector>

namespace raybundle::linalg {

/// Extreme eigenvalues of the blocks of a block-diagonal matrix, symmetric and positive
/// semi-definite. An eigenvalue is as accurate as rounding of the largest of its block allows.
struct BlockSpectrum {
  double smallest = 0;         ///< of all blocks; 0 where there is nothing to count
  double largest = 0;          ///< of all blocks
  double worst_condition = 1;  ///< of one block; infinite where one is not positive definite
};

/// `blocks`: count x (size x size), size at most 12; `damping`: count x size to be added to the
/// diagonal, or null. Unknowns without information (a zero on the diagonal of their block) are left
/// out, as they are never moved. All is infinite or NaN where a block is not finite.
BlockSpectrum block_spectrum(const double* blocks, int size, std::int64_t count,
                             const double* damping, ThreadPool& pool);

/// Extreme eigenvalues of one matrix.
struct Spectrum {
  double smallest = 0;  ///< 0 where it is not positive definite as far as rounding tells
  double largest = 0;
};

/// The spectrum of the reduced system of the hubs without damping, S_C of [Qu18, Eq. 3.64]:
/// Lanczos [GolubVanLoan13, 10.1] on the implicit product, and on its inverse through a Cholesky
/// factorisation, which finds small eigenvalues to high relative accuracy. Unknowns that no row
/// feels are left out. It holds a system and a factorisation of its own.
class ReducedSpectrum {
 public:
  /// `layout` and `pool` outlive it. Throws std::bad_alloc or MemoryRefusal.
  ReducedSpectrum(const BlockLayout& layout, ThreadPool& pool);

  /// NaN where the linearisation is not finite.
  Spectrum measure(const Linearization& at);

 private:
  std::vector<double> start() const;

  ThreadPool& pool_;
  std::unique_ptr<ReducedSystem> system_;
  std::unique_ptr<Cholesky> cholesky_;
  std::vector<double> damping_;  // 1 for unknowns that no row feels
  std::vector<double> gradient_;
};

}  // namespace raybundle::linalg
