#include <raybundle/linalg/pcg.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/linalg/vector.h>

#include <algorithm>
#include <cmath>

namespace raybundle::linalg {

Pcg::Pcg(std::int64_t size, ThreadPool& pool)
    : pool_(pool), r_(index(size)), q_(index(size)), a_(index(size)), Aa_(index(size)) {}

double Pcg::dot(const std::vector<double>& u, const std::vector<double>& v) const {
  return linalg::dot(u.data(), v.data(), static_cast<std::int64_t>(u.size()), pool_);
}

Pcg::Result Pcg::solve(const Operator& A, const Operator& precondition, const double* b,
                       double tolerance, int max_iterations, double* x) {
  const std::size_t size = r_.size();
  std::fill_n(x, size, 0.0);
  for (std::size_t i = 0; i < size; ++i) r_[i] = -b[i];
  precondition(r_.data(), q_.data());
  for (std::size_t i = 0; i < size; ++i) a_[i] = -q_[i];
  double rq = dot(r_, q_);
  Result result;
  result.residual_norm = std::sqrt(dot(r_, r_));

  // Written so that a residual that is not a number breaks down instead of ending well.
  while (!(result.residual_norm <= tolerance)) {
    if (result.iterations == max_iterations) {
      result.end = End::max_iterations;
      break;
    }
    A(a_.data(), Aa_.data());
    const double curvature = dot(a_, Aa_);
    if (!(curvature > 0) || !(rq > 0)) {
      result.end = End::breakdown;
      break;
    }
    const double alpha = rq / curvature;
    for (std::size_t i = 0; i < size; ++i) {
      x[i] += alpha * a_[i];
      r_[i] += alpha * Aa_[i];
    }
    precondition(r_.data(), q_.data());
    const double next = dot(r_, q_);
    const double beta = next / rq;
    rq = next;
    for (std::size_t i = 0; i < size; ++i) a_[i] = -q_[i] + beta * a_[i];
    result.residual_norm = std::sqrt(dot(r_, r_));
    ++result.iterations;
  }
  return result;
}

}  // namespace raybundle::linalg
