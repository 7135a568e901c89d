#include <raybundle/linalg/reduced_pattern.h>
#include <raybundle/solver/linear_work.h>
#include <raybundle/solver/step.h>

#include <new>
#include <optional>
#include <utility>

namespace raybundle {
namespace {

constexpr int first_guess = 10;  // inner iterations of the first step

// Damped steps by factorisation or by conjugate gradients, whichever is predicted to be the lesser
// work. How many inner iterations there will be nobody knows beforehand: the first step assumes
// some, every later one as many as the last had, or, where these were so many that the next has a
// coarse space, as many as steps with one mostly take. Once it factorises it goes on doing so; to
// change over takes a plan first, about as much work again as one assembly.
class AutomaticStep final : public StepSolver {
 public:
  AutomaticStep(const Options& options, const linalg::BlockLayout& layout, linalg::ThreadPool& pool)
      : options_(options), layout_(layout), pool_(pool), work_(linear_work(layout)) {
    decide(work_of(first_guess, false));
    if (!cholesky_ && !pcg_) pcg_ = make_pcg_step(options, Elimination::points, layout, pool);
  }

  StepReport solve(const StepRequest& request, double* step) override {
    if (!cholesky_ && last_iterating_ > 0) decide(last_iterating_);
    if (cholesky_) return cholesky_->solve(request, step);
    const StepReport report = pcg_->solve(request, step);
    last_iterating_ = work_of(report.inner_iterations, report.two_level);
    return report;
  }

  Linear linear() const override { return cholesky_ ? cholesky_->linear() : pcg_->linear(); }
  double matrix_memory() const override { return cholesky_ ? cholesky_->matrix_memory() : 0; }
  std::string description() const override {
    return cholesky_ ? before_ + cholesky_->description() : pcg_->description();
  }

 private:
  static constexpr int guess_of_two_levels = 20;

  // Of a step after one that took so many inner iterations, by two levels or not.
  double work_of(int inner_iterations, bool two_level) const {
    const double one_level = work_.preparation + inner_iterations * work_.product;
    if (two_level) return one_level + work_.coarse;
    if (inner_iterations <= many_inner_iterations) return one_level;
    return work_.preparation + work_.coarse + guess_of_two_levels * work_.product;
  }

  void decide(double iterating) {
    const double planning = pcg_ ? work_.assembly : 0;
    if (refused_ || planning + work_.assembly > iterating) return;
    if (!plan_) make_plan();
    if (!plan_ || work_.assembly + plan_->work > iterating) return;
    if (pcg_) before_ = pcg_->description() + ", then ";
    pcg_.reset();  // its memory first
    try {
      cholesky_ = make_cholesky_step(options_, layout_, pool_, std::move(*plan_));
    } catch (const std::bad_alloc&) {
      refused_ = true;
      pcg_ = make_pcg_step(options_, Elimination::points, layout_, pool_);
    }
  }

  void make_plan() {
    try {
      plan_ = linalg::plan_cholesky(linalg::reduced_pattern(layout_, linalg::Side::leaves));
      if (plan_->memory <= options_.memory_limit) return;
      refused_ = true;
      plan_.reset();
    } catch (const std::bad_alloc&) {
      refused_ = true;  // conjugate gradients need no such matrix
    }
  }

  Options options_;
  const linalg::BlockLayout& layout_;
  linalg::ThreadPool& pool_;
  LinearWork work_;
  std::optional<linalg::CholeskyPlan> plan_;
  bool refused_ = false;
  double last_iterating_ = 0;  // predicted from the last step; 0: there was none
  std::unique_ptr<StepSolver> cholesky_;
  std::unique_ptr<StepSolver> pcg_;
  std::string before_;  // what was used until now, in words
};

}  // namespace

std::optional<linalg::CholeskyPlan> first_automatic_plan(const linalg::BlockLayout& layout) {
  const LinearWork work = linear_work(layout);
  const double iterating = work.preparation + first_guess * work.product;
  if (work.assembly > iterating) return std::nullopt;
  try {
    auto plan = linalg::plan_cholesky(linalg::reduced_pattern(layout, linalg::Side::leaves));
    if (work.assembly + plan.work <= iterating) return plan;
  } catch (const std::bad_alloc&) {
    // then it iterates
  }
  return std::nullopt;
}

std::unique_ptr<StepSolver> make_automatic_step(const Options& options,
                                                const linalg::BlockLayout& layout,
                                                linalg::ThreadPool& pool) {
  return std::make_unique<AutomaticStep>(options, layout, pool);
}

}  // namespace raybundle
