#include <raybundle/linalg/pcg.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/linalg/vector.h>

#include <cmath>

namespace raybundle::linalg {
Pcg::Pcg(std::int64_t size, ThreadPool& pool)
    : size_(size),
      pool_(pool),
      r_(index(size)),
      q_(index(size)),
      a_(index(size)),
      Aa_(index(size)) {}

double Pcg::dot(const double* u, const double* v) const { return linalg::dot(u, v, size_, pool_); }

// |x + tau a|^2 = aa tau^2 + 2 xa tau + xx along the direction a  [Qu18, Eq. 3.93].
struct Pcg::Ray {
  double aa, xa, xx;

  bool leaves(double tau, double radius) const {
    return !((aa * tau + 2 * xa) * tau + xx < radius * radius);
  }
  // The larger root of |x + tau a| = radius, without subtracting what nearly cancels.
  double to_boundary(double radius) const {
    const double room = radius * radius - xx;
    if (!(room > 0) || !(aa > 0)) return 0;
    const double root = std::sqrt(xa * xa + aa * room);
    return xa > 0 ? room / (xa + root) : (root - xa) / aa;
  }
};

Pcg::Ray Pcg::ray(const double* x) const {
  return {dot(a_.data(), a_.data()), dot(x, a_.data()), dot(x, x)};
}

Pcg::Result Pcg::solve(const Operator& A, const Operator& precondition, const double* b,
                       const Stop& stop, double* x) {
  const bool bounded = std::isfinite(stop.radius);
  const auto each = [&](auto&& update) { for_entries(size_, pool_, update); };
  each([&](std::size_t i) {
    x[i] = 0;
    r_[i] = -b[i];
  });
  precondition(r_.data(), q_.data());
  each([&](std::size_t i) { a_[i] = -q_[i]; });
  double rq = dot(r_.data(), q_.data());
  double decrease = 0;
  Result result;
  result.residual_norm = std::sqrt(dot(r_.data(), r_.data()));

  const auto end_at_boundary = [&](double tau) {
    each([&](std::size_t i) { x[i] += tau * a_[i]; });
    ++result.iterations;
    result.end = End::boundary;
  };

  // Written so that a residual that is not a number breaks down instead of ending well.
  while (!(result.residual_norm <= stop.residual)) {
    if (result.iterations == stop.max_iterations) {
      result.end = End::max_iterations;
      break;
    }
    A(a_.data(), Aa_.data());
    const double curvature = dot(a_.data(), Aa_.data());
    if (!(rq > 0) || std::isnan(curvature) || (curvature <= 0 && !bounded)) {
      result.end = End::breakdown;
      break;
    }
    const double alpha = rq / curvature;
    if (bounded) {
      const Ray along = ray(x);
      if (curvature <= 0 || along.leaves(alpha, stop.radius)) {
        end_at_boundary(along.to_boundary(stop.radius));
        break;
      }
    }
    each([&](std::size_t i) {
      x[i] += alpha * a_[i];
      r_[i] += alpha * Aa_[i];
    });
    ++result.iterations;
    const double gain = 0.5 * alpha * rq;  // the quadratic falls by alpha rq - 1/2 alpha^2 a^T A a
    decrease += gain;
    precondition(r_.data(), q_.data());
    const double next = dot(r_.data(), q_.data());
    const double beta = next / rq;
    rq = next;
    each([&](std::size_t i) { a_[i] = -q_[i] + beta * a_[i]; });
    result.residual_norm = std::sqrt(dot(r_.data(), r_.data()));
    if (result.iterations * gain <= stop.model_decrease * decrease) break;
  }
  return result;
}

}  // namespace raybundle::linalg
