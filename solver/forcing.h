#pragma once

#include <raybundle/solver/options.h>

namespace raybundle {

/// How exactly one linear system is solved: A x = b ends at the first of
///   |A x - b| <= relative_residual |b|, or min(relative_residual, |b|) |b| where `by_norm`;
///   an iteration's decrease of the quadratic is at most `model_decrease` of the mean so far.
struct InnerTolerance {
  double relative_residual = 0;
  bool by_norm = false;
  double model_decrease = 0;
};

/// The forcing sequence: from verdicts to the tolerance of the next linear system.
class Forcing {
 public:
  /// `t` is the constant of each rule, in (0, 1): see ForcingRule.
  Forcing(ForcingRule rule, double t) : rule_(rule), t_(t), relative_(t) {}

  /// A new linearisation, whose gradient has this norm.
  void linearized(double gradient_norm);
  InnerTolerance tolerance() const;

 private:
  ForcingRule rule_;
  double t_;
  double relative_;
  double previous_norm_ = 0;
};

}  // namespace raybundle
