#pragma once

#include <raybundle/linalg/spectrum.h>
#include <raybundle/solver/summary.h>

namespace raybundle {

/// Measures how near a linearisation is to singular. It has a linear system of its own, whatever
/// the method's.
class Diagnoser {
 public:
  /// layout and pool outlive it. Throws std::bad_alloc or MemoryRefusal.
  Diagnoser(const linalg::BlockLayout& layout, linalg::ThreadPool& pool);

  /// Bytes, without the matrix.
  static double memory(const linalg::LayoutSize& n);

  Diagnosis measure(const linalg::Linearization& at);

 private:
  const linalg::BlockLayout& layout_;
  linalg::ThreadPool& pool_;
  linalg::ReducedSpectrum reduced_;
};

}  // namespace raybundle
