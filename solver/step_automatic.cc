#include <raybundle/linalg/reduced_pattern.h>
#include <raybundle/solver/linear_work.h>
#include <raybundle/solver/step.h>

#include <new>
#include <optional>
#include <utility>

namespace raybundle {
namespace {

// Damped steps in whichever way is predicted to be the least work. How many inner iterations there
// will be nobody knows beforehand: the first step assumes some, every later one as many as the last
// had. The sparsity of the matrix, which the other ways depend on, is asked for once they may be
// less than iterating without it even if it costs as much as it may. Changes go one way: from
// products with the Jacobian to those with the matrix, and from either to a factorisation.
class AutomaticStep final : public StepSolver {
 public:
  AutomaticStep(const Options& options, const linalg::BlockLayout& layout, linalg::ThreadPool& pool)
      : options_(options), layout_(layout), pool_(pool), forecast_(layout) {
    decide(first_guess);
  }

  StepReport solve(const StepRequest& request, double* step) override {
    if (iterates(linear()) && last_inner_iterations_ > 0) decide(last_inner_iterations_);
    const StepReport report = solver_->solve(request, step);
    last_inner_iterations_ = report.inner_iterations;
    return report;
  }

  Linear linear() const override { return solver_->linear(); }
  std::string description() const override { return before_ + solver_->description(); }
  LinearChoice choice() const override { return {forecast_.candidates(), decided_for_}; }

 private:
  static constexpr int first_guess = 10;

  void decide(int inner_iterations) {
    while (is_worth_learning(inner_iterations)) learn();
    const LinearCandidate& found = forecast_.best(inner_iterations);
    const Linear best = found.lower_bound ? Linear::implicit_pcg : found.linear;
    if (!solver_) {
      take(best, inner_iterations);
    } else if (best < solver_->linear()) {  // the enumeration goes from fixed to growing work
      before_ += solver_->description() + ", then ";
      take(best, inner_iterations);
    }
  }

  bool is_worth_learning(int inner_iterations) const {
    const LinearCandidate& best = forecast_.best(inner_iterations);
    if (refused_ || !best.lower_bound) return false;
    const double extra = solver_ ? forecast_.planning() : 0;
    const double iterating = LinearForecast::work(forecast_.candidates().back(), inner_iterations);
    return LinearForecast::work(best, inner_iterations) + extra < iterating;
  }

  // First the sparsity of the matrix, then what it takes to factorise it.
  void learn() {
    try {
      if (!plan_) {
        plan_.emplace();
        plan_->pattern = linalg::reduced_pattern(layout_, linalg::Side::leaves, pool_);
        forecast_.add(plan_->pattern);
      } else {
        plan_ = linalg::plan_cholesky(std::move(plan_->pattern), pool_.threads());
        forecast_.add(*plan_);
      }
    } catch (const std::bad_alloc&) {
      plan_.reset();  // conjugate gradients need no such matrix
      refused_ = true;
    }
  }

  void take(Linear linear, int inner_iterations) {
    decided_for_ = inner_iterations;
    solver_.reset();  // its memory first
    try {
      solver_ = make(linear);
    } catch (const std::bad_alloc&) {
      plan_.reset();
      refused_ = true;
      solver_ = make(Linear::implicit_pcg);
    }
  }

  std::unique_ptr<StepSolver> make(Linear linear) {
    if (linear == Linear::implicit_pcg) {
      return make_pcg_step(options_, Elimination::points, layout_, pool_);
    }
    if (linear == Linear::explicit_pcg) {
      return make_explicit_pcg_step(options_, Elimination::points, layout_, pool_, plan_->pattern);
    }
    using linalg::CholeskyKind;
    const auto kind = linear == Linear::dense_cholesky ? CholeskyKind::dense : CholeskyKind::sparse;
    if (plan_->kind != kind ||
        plan_->work == 0) {  // the other one does not fit, or not planned yet
      plan_ = linalg::plan_cholesky(std::move(plan_->pattern), pool_.threads(), kind);
    }
    return make_cholesky_step(options_, layout_, pool_, std::move(*plan_));
  }

  Options options_;
  const linalg::BlockLayout& layout_;
  linalg::ThreadPool& pool_;
  LinearForecast forecast_;
  std::optional<linalg::CholeskyPlan> plan_;
  bool refused_ = false;
  int decided_for_ = 0;  // inner iterations
  int last_inner_iterations_ = 0;
  std::unique_ptr<StepSolver> solver_;
  std::string before_;  // what was used until now, in words
};

}  // namespace

std::unique_ptr<StepSolver> make_automatic_step(const Options& options,
                                                const linalg::BlockLayout& layout,
                                                linalg::ThreadPool& pool) {
  return std::make_unique<AutomaticStep>(options, layout, pool);
}

}  // namespace raybundle
