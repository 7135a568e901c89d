#include <raybundle/solver/automatic_choice.h>

#include <raybundle/linalg/reduced_pattern.h>

#include <new>
#include <utility>

namespace raybundle {

Linear AutomaticChoice::decide(InnerIterations expected, bool first) {
  while (is_worth_learning(expected, first)) learn();
  const LinearCandidate& best = forecast_.best(expected);
  return refused_ || best.lower_bound ? Linear::implicit_pcg : best.linear;
}

bool AutomaticChoice::is_worth_learning(InnerIterations expected, bool first) const {
  const LinearCandidate& best = forecast_.best(expected);
  if (refused_ || !best.lower_bound) return false;
  const double extra = first ? 0 : forecast_.planning();
  const LinearCandidate& without = forecast_.candidates().back();
  return best.work_with(expected) + extra < without.work_with(expected);
}

// First the sparsity of the matrix, then what it takes to factorise it.
void AutomaticChoice::learn() {
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

linalg::CholeskyPlan AutomaticChoice::take_plan(Linear linear) {
  using linalg::CholeskyKind;
  const auto kind = linear == Linear::dense_cholesky ? CholeskyKind::dense : CholeskyKind::sparse;
  // The other one may not fit, or none is planned yet.
  if (plan_->kind != kind || plan_->work == 0) {
    plan_ = linalg::plan_cholesky(std::move(plan_->pattern), pool_.threads(), kind);
  }
  return std::move(*plan_);
}

}  // namespace raybundle
