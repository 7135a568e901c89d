#pragma once

#include <raybundle/linalg/parallel.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace raybundle::linalg {

/// Preconditioned conjugate gradients for A x = b from x = 0, with A symmetric positive definite
/// [Qu18, Alg. 1]. As printed there, line 1 starts with r = b; the residual is r = A x - b, so the
/// start is r = -b.
class Pcg {
 public:
  using Operator = std::function<void(const double* x, double* y)>;
  enum class End { tolerance, max_iterations, breakdown };
  struct Result {
    End end = End::tolerance;
    int iterations = 0;
    double residual_norm = 0;  ///< |A x - b|, Euclidean, as the recurrence has it
  };

  Pcg(std::int64_t size, ThreadPool& pool);

  /// Stops at |A x - b| <= tolerance, after max_iterations, or breaks down where a direction has no
  /// positive curvature (rounding, an A that is only semi-definite, numbers that are not finite); x
  /// is then the best found, which after no iteration is 0.
  Result solve(const Operator& A, const Operator& precondition, const double* b, double tolerance,
               int max_iterations, double* x);

 private:
  double dot(const std::vector<double>& u, const std::vector<double>& v) const;

  ThreadPool& pool_;
  std::vector<double> r_;  // residual A x - b
  std::vector<double> q_;  // preconditioned residual
  std::vector<double> a_;  // direction
  std::vector<double> Aa_;
};

}  // namespace raybundle::linalg
