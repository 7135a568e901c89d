// Powell's dogleg [Liu18, Table 1; NocedalWright06, 4.1]: the path from the state to the minimum of
// the model along the steepest descent (Cauchy point), and on to the minimum of the model (Gauss-
// Newton point), cut where it leaves the trust region |D p| <= radius. With the scaled gradient
// s = D^-1 g,
//   p_C = -|s|^2 / |J D^-1 s|^2  D^-1 s,    p_N = -H^-1 g.
// Both points belong to the linearisation: a retry with a smaller radius costs two vector sums.

#include <raybundle/linalg/cholesky.h>
#include <raybundle/linalg/vector.h>
#include <raybundle/solver/step.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace raybundle {
namespace {

using linalg::index;

// Where the normal equations cannot be factorised, diag(H) times these is added in turn: nothing at
// first (the least where the gauge is free, which makes them singular), and at most a step that is
// still mostly Gauss-Newton's.
constexpr double least_regularisation = 1e-12;
constexpr double most_regularisation = 1e-2;
constexpr double regularisation_factor = 100;

class DoglegStep final : public StepSolver {
 public:
  DoglegStep(const Options& options, const linalg::BlockLayout& layout, linalg::ThreadPool& pool)
      : pool_(pool),
        elimination_(*options.elimination),
        first_regularisation_(options.gauge == Gauge::free ? least_regularisation : 0),
        newton_solver_(make_cholesky_step(options, layout, pool)),
        unknowns_(layout.unknowns()),
        cauchy_(index(unknowns_)),
        newton_(index(unknowns_)),
        diagonal_(index(unknowns_)),
        damping_(index(unknowns_)) {}

  StepReport solve(const StepRequest& request, double* step) override {
    StepReport report = {.eliminated = elimination_, .linear_solves = 0};
    if (request.relinearised) {
      find_cauchy_point(request);
      find_newton_point(request, report);
    }
    report.regularisation = regularisation_ > first_regularisation_ ? regularisation_ : 0;
    if (!have_newton_) return report;
    report.solved = true;
    follow_path(request, step, report);
    return report;
  }

  Linear linear() const override { return newton_solver_->linear(); }
  double matrix_memory() const override { return newton_solver_->matrix_memory(); }
  std::string description() const override { return newton_solver_->description(); }

 private:
  double inverse_scaling(const StepRequest& request, std::size_t i) const {
    return request.inverse_scaling == nullptr ? 1.0 : request.inverse_scaling[i];
  }

  // u . v of scaled unknowns.
  double scaled_dot(const StepRequest& request, const linalg::LargeVector<double>& u,
                    const linalg::LargeVector<double>& v) const {
    return linalg::parallel_sum(pool_, unknowns_, 16384,
                                [&](std::int64_t first, std::int64_t last) {
                                  double sum = 0;
                                  for (std::int64_t i = first; i < last; ++i) {
                                    const double inverse = inverse_scaling(request, index(i));
                                    sum += u[index(i)] * v[index(i)] / (inverse * inverse);
                                  }
                                  return sum;
                                });
  }

  double length(const StepRequest& request, const linalg::LargeVector<double>& p) const {
    return std::sqrt(scaled_dot(request, p, p));
  }

  void find_cauchy_point(const StepRequest& request) {
    const linalg::LargeVector<double>& g = request.at.normal->gradient;
    linalg::for_entries(unknowns_, pool_, [&](std::size_t i) {
      const double inverse = inverse_scaling(request, i);
      cauchy_[i] = -inverse * inverse * g[i];
    });
    const double slope = -linalg::dot(g.data(), cauchy_.data(), unknowns_, pool_);
    const double curvature = linalg::multiply_squares(*request.at.J, cauchy_.data(), pool_);
    const double along = curvature > 0 ? slope / curvature : 0;
    linalg::for_entries(unknowns_, pool_, [&](std::size_t i) { cauchy_[i] *= along; });
    cauchy_length_ = length(request, cauchy_);
  }

  void find_newton_point(const StepRequest& request, StepReport& report) {
    request.at.normal->diagonal(0, std::numeric_limits<double>::max(), diagonal_.data(), pool_);
    regularisation_ = first_regularisation_;
    StepRequest inner = request;
    inner.damping = damping_.data();
    do {
      // What nothing depends on (fixed, or seen by nobody) stays where it is.
      linalg::for_entries(unknowns_, pool_, [&](std::size_t i) {
        damping_[i] = diagonal_[i] > 0 ? regularisation_ * diagonal_[i] : 1.0;
      });
      have_newton_ =
          newton_solver_->solve(inner, newton_.data()).solved && newton_descends(request);
      ++report.linear_solves;
      if (have_newton_) break;
      regularisation_ = std::max(least_regularisation, regularisation_ * regularisation_factor);
    } while (regularisation_ <= most_regularisation);
    if (have_newton_) newton_length_ = length(request, newton_);
  }

  bool newton_descends(const StepRequest& request) const {
    const double slope =
        linalg::dot(request.at.normal->gradient.data(), newton_.data(), unknowns_, pool_);
    return std::isfinite(slope) && slope <= 0;
  }

  void follow_path(const StepRequest& request, double* step, StepReport& report) const {
    double of_cauchy = 0, of_newton = 1;
    report.length = newton_length_;
    if (newton_length_ > request.radius) {
      report.on_boundary = true;
      report.length = request.radius;
      if (cauchy_length_ >= request.radius) {
        of_cauchy = request.radius / cauchy_length_;
        of_newton = 0;
      } else {
        of_newton = share_of_newton(request);
        of_cauchy = 1 - of_newton;
      }
    }
    linalg::for_entries(unknowns_, pool_, [&](std::size_t i) {
      step[i] = of_cauchy * cauchy_[i] + of_newton * newton_[i];
    });
  }

  // The t in [0, 1] with |D (p_C + t (p_N - p_C))| = radius, from
  //   |d|^2 t^2 + 2 p_C.d t - (radius^2 - |p_C|^2) = 0,  d = p_N - p_C, lengths being scaled.
  double share_of_newton(const StepRequest& request) const {
    const double product = scaled_dot(request, cauchy_, newton_);
    const double cc = cauchy_length_ * cauchy_length_;
    const double a = newton_length_ * newton_length_ - 2 * product + cc;
    const double b = product - cc;
    const double c = request.radius * request.radius - cc;
    const double root = std::sqrt(b * b + a * c);
    // The form without cancellation.
    const double t = b > 0 ? c / (b + root) : (root - b) / a;
    return std::clamp(t, 0.0, 1.0);
  }

  linalg::ThreadPool& pool_;
  Elimination elimination_;
  double first_regularisation_;
  std::unique_ptr<StepSolver> newton_solver_;
  std::int64_t unknowns_;
  linalg::LargeVector<double> cauchy_;
  linalg::LargeVector<double> newton_;
  linalg::LargeVector<double> diagonal_;
  linalg::LargeVector<double> damping_;
  double cauchy_length_ = 0;
  double newton_length_ = 0;
  double regularisation_ = 0;
  bool have_newton_ = false;
};

}  // namespace

double dogleg_step_memory(const Options& options, const linalg::LayoutSize& n) {
  return cholesky_step_memory(options, n) + 8 * 4 * static_cast<double>(n.unknowns());
}

std::unique_ptr<StepSolver> make_dogleg_step(const Options& options,
                                             const linalg::BlockLayout& layout,
                                             linalg::ThreadPool& pool) {
  return std::make_unique<DoglegStep>(options, layout, pool);
}

}  // namespace raybundle
