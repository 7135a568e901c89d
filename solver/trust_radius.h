#pragma once

#include <limits>
#include <optional>

namespace raybundle {

/// What a radius does after a bad step, and after a good one that the region cut.
struct RadiusRule {
  double shrink = 0.25;
  double grow = 2;
};

/// The radius of the trust region |D p| <= radius and its update [Qu18, Alg. 2], after
/// [NocedalWright06, Alg. 4.1].
class TrustRadius {
 public:
  /// Without an initial radius the first step is free, and its length becomes the radius: nobody
  /// knows the scale of a problem better than its own first step.
  explicit TrustRadius(std::optional<double> initial, RadiusRule rule = {})
      : rule_(rule), radius_(initial.value_or(std::numeric_limits<double>::infinity())) {}

  double radius() const { return radius_; }

  /// `rho`: actual over predicted decrease, NaN counting as a failure; `length`: |D p| of the step,
  /// which `on_boundary` says the region has cut. As printed a failure leaves a quarter of the
  /// radius; here it leaves a quarter of the step where that is shorter, or a step from inside the
  /// region would be tried again unchanged.
  void update(double rho, bool on_boundary, double length);

 private:
  RadiusRule rule_;
  double radius_;
};

}  // namespace raybundle
