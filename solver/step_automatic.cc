#include <raybundle/solver/automatic_choice.h>
#include <raybundle/solver/step.h>

#include <new>
#include <utility>

namespace raybundle {
namespace {

// Damped steps in the way that AutomaticChoice finds. How many inner iterations there will be
// nobody knows beforehand: the first step assumes some, every later one what those of the one
// before let expect. Changes go one way: from products with the Jacobian to those with the matrix,
// and from either to a factorisation.
class AutomaticStep final : public StepSolver {
 public:
  AutomaticStep(const Options& options, const linalg::BlockLayout& layout, linalg::ThreadPool& pool)
      : options_(options),
        layout_(layout),
        pool_(pool),
        choice_(layout, pool, options.memory_limit) {
    take(choice_.decide(expected_, true));
  }

  StepReport solve(const StepRequest& request, double* step) override {
    if (iterates(linear()) && iterated_) reconsider(request.grown);
    const StepReport report = solver_->solve(request, step);
    iterated_ = report.inner_iterations > 0;
    if (iterated_) expected_ = expected_after(report);
    return report;
  }

  Linear linear() const override { return solver_->linear(); }
  double matrix_memory() const override { return solver_->matrix_memory(); }
  std::string description() const override { return before_ + solver_->description(); }
  LinearChoice choice() const override { return {choice_.forecast().candidates(), decided_for_}; }

 private:
  void reconsider(double grown) {
    if (grown > 0) choice_.leave(options_.memory_limit - grown);
    const Linear best = choice_.decide(expected_, false);
    if (best >= linear()) return;  // the enumeration goes from fixed to growing work
    before_ += solver_->description() + ", then ";
    take(best);
  }

  void take(Linear linear) {
    decided_for_ = expected_;
    solver_.reset();  // its memory first
    try {
      solver_ = make(linear);
    } catch (const std::bad_alloc&) {
      choice_.give_up();
      solver_ = make(Linear::implicit_pcg);
    }
  }

  std::unique_ptr<StepSolver> make(Linear linear) {
    if (linear == Linear::implicit_pcg) {
      return make_pcg_step(options_, Elimination::points, layout_, pool_);
    }
    if (linear == Linear::explicit_pcg) {
      Options options = options_;
      if (expected_.two_level) options.preconditioner = Preconditioner::two_level;
      return make_explicit_pcg_step(options, Elimination::points, layout_, pool_,
                                    choice_.pattern());
    }
    return make_cholesky_step(options_, layout_, pool_, choice_.take_plan(linear));
  }

  Options options_;
  const linalg::BlockLayout& layout_;
  linalg::ThreadPool& pool_;
  AutomaticChoice choice_;
  InnerIterations expected_;     // in the next step
  InnerIterations decided_for_;  // when the way was chosen
  bool iterated_ = false;        // in the last step
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
