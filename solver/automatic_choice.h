#pragma once

#include <raybundle/linalg/cholesky.h>
#include <raybundle/solver/linear_work.h>

#include <optional>

namespace raybundle {

/// By what method `auto` takes its damped steps: in whichever way is predicted to be the least
/// work. The sparsity of the matrix, which the ways that form it depend on, is asked for once they
/// may be less than iterating without it even if it costs as much as it may; after the first step
/// they must also save in one step what it takes to plan them.
class AutomaticChoice {
 public:
  /// `memory_limit`: bytes that matrix and factor may take; layout and pool outlive this.
  AutomaticChoice(const linalg::BlockLayout& layout, linalg::ThreadPool& pool, double memory_limit)
      : layout_(layout), pool_(pool), forecast_(layout, memory_limit) {}

  /// Of a step; `first`: of the first one.
  Linear decide(InnerIterations expected, bool first);
  /// From now on so many bytes.
  void leave(double memory_limit) { forecast_.leave(memory_limit); }
  /// After a failure to allocate: products with the Jacobian are all that is left.
  void give_up() { refused_ = true; }

  /// How to factorise in the way that was chosen, which must be one of these; once.
  linalg::CholeskyPlan take_plan(Linear linear);
  const linalg::SymmetricPattern& pattern() const { return plan_->pattern; }
  const LinearForecast& forecast() const { return forecast_; }

 private:
  bool is_worth_a_change(InnerIterations expected, bool first) const;
  void learn();

  const linalg::BlockLayout& layout_;
  linalg::ThreadPool& pool_;
  LinearForecast forecast_;
  std::optional<linalg::CholeskyPlan> plan_;
  Linear chosen_ = Linear::implicit_pcg;
  bool refused_ = false, sampled_ = false;
};

}  // namespace raybundle
