#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <raybundle/linalg/large_vector.h>
#include <raybundle/linalg/normal_equations.h>
#include <raybundle/linalg/parallel.h>
#include <raybundle/linalg/schur_complement.h>
#include <raybundle/linalg/symmetric_blocks.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/problem.h>

namespace raybundle::bench {

/// Photographs of about so many observations, away from the solution.
Problem photos(std::int64_t observations);

/// All that a step is computed from, linearised and with the points eliminated, so that each kernel
/// can run by itself, as often as wanted.
struct Workload {
  Workload(std::int64_t observations, int threads);

  /// The reduced matrix, whose sparsity is found when it is first asked for.
  linalg::SymmetricBlocks& reduced_matrix();
  /// Numbers stored in it.
  std::int64_t reduced_nonzeros() const;
  linalg::Linearization at() const { return {&J, &normal}; }

  linalg::ThreadPool pool;
  Problem problem;
  Objective objective;
  const linalg::BlockLayout& layout;
  State state;
  linalg::BlockJacobian J;
  linalg::NormalEquations normal;
  std::vector<double> damping;
  linalg::SchurComplement schur;
  std::vector<double> x, y, step;
  linalg::DiagonalBlocks diagonal;
  std::int64_t couples =
      0;  ///< couplings of a point with its own and later ones, summed over points

 private:
  std::optional<linalg::SymmetricBlocks> reduced_;
};

/// One workload is kept at a time.
Workload& workload(std::int64_t observations, int threads);

}  // namespace raybundle::bench
