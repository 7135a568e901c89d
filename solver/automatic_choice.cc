#include <raybundle/solver/automatic_choice.h>

#include <raybundle/linalg/reduced_pattern.h>

#include <new>
#include <utility>

namespace raybundle {
namespace {

constexpr double convincing = 1.25;  // of what is known, in what is guessed

}  // namespace

Linear AutomaticChoice::decide(InnerIterations expected, bool first) {
  while (forecast_.best(expected).lower_bound && is_worth_a_change(expected, first)) learn();
  const bool formed = chosen_ != Linear::implicit_pcg || is_worth_a_change(expected, first);
  const LinearCandidate& best = forecast_.best(expected);
  chosen_ = formed && !refused_ && !best.lower_bound ? best.linear : Linear::implicit_pcg;
  return chosen_;
}

// To a way that forms the matrix, which has to be planned.
bool AutomaticChoice::is_worth_a_change(InnerIterations expected, bool first) const {
  if (refused_) return false;
  const LinearCandidate& best = forecast_.best(expected);
  const LinearCandidate& without = forecast_.candidates().back();
  if (first) {
    return LinearForecast::weighed(best, expected) < LinearForecast::weighed(without, expected);
  }
  return convincing * best.work_with(expected) + forecast_.planning() < without.work_with(expected);
}

// First about how many blocks the matrix has, then which, then what it takes to factorise it.
void AutomaticChoice::learn() {
  try {
    if (!sampled_) {
      forecast_.expect(linalg::sampled_reduced_blocks(layout_, linalg::Side::leaves, pool_));
      sampled_ = true;
    } else if (!plan_) {
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
