#pragma once

#include <raybundle/linalg/parallel.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace raybundle::linalg {

/// Preconditioned conjugate gradients from x = 0, free [Qu18, Alg. 1] or within a trust region,
/// after Steihaug [Qu18, Alg. 3]:
///   min 1/2 x^T A x - b^T x  subject to |x| <= radius  [Qu18, Eq. 3.91].
/// Both are printed with r = b at the start; the residual is r = A x - b, so the start is r = -b.
///
/// The region is bounded by the Euclidean norm of x, with or without a preconditioner. Without one
/// the iterates grow in that norm, so the first crossing is the only one; with one they grow in the
/// preconditioner's norm only, and the first crossing is where the iteration ends all the same.
/// Every iterate lowers the quadratic, so every end is a decrease.
class Pcg {
 public:
  using Operator = std::function<void(const double* x, double* y)>;

  /// When to end; whatever comes first.
  struct Stop {
    double residual = 0;  ///< at |A x - b| <= residual, Euclidean
    double model_decrease =
        0;  ///< when an iteration decreases the quadratic by at most this share of
            ///< the mean decrease of all so far [NashSofer90]; 0: never
    int max_iterations = std::numeric_limits<int>::max();
    double radius = std::numeric_limits<double>::infinity();  ///< |x| stays within
  };
  enum class End {
    tolerance,       ///< the residual or the decrease is small enough
    max_iterations,  ///< and not yet small enough
    boundary,        ///< |x| is the radius: crossed, or left along a direction of no curvature
    breakdown        ///< no curvature and no region, or numbers that are not finite
  };
  struct Result {
    End end = End::tolerance;
    int iterations = 0;
    double residual_norm = 0;  ///< |A x - b|, Euclidean, as the recurrence has it; before the last
                               ///< direction, where that ended on the boundary
  };

  Pcg(std::int64_t size, ThreadPool& pool);
  static double memory(std::int64_t size) { return 32 * static_cast<double>(size); }

  /// A symmetric. After a breakdown x is the best found, which after no iteration is 0. Directions
  /// have no positive curvature where A is only semi-definite, or by rounding.
  Result solve(const Operator& A, const Operator& precondition, const double* b, const Stop& stop,
               double* x);

 private:
  struct Ray;
  double dot(const double* u, const double* v) const;
  Ray ray(const double* x) const;

  std::int64_t size_;
  ThreadPool& pool_;
  std::vector<double> r_;  // residual A x - b
  std::vector<double> q_;  // preconditioned residual
  std::vector<double> a_;  // direction
  std::vector<double> Aa_;
};

}  // namespace raybundle::linalg
