#include <raybundle/solver/forcing.h>

#include <algorithm>
#include <cmath>

namespace raybundle {

// Choice 2 of [EisenstatWalker96, Eq. 2.6] with gamma = 0.9 and alpha = (1 + sqrt 5) / 2, kept from
// falling too fast by their safeguard, and never above t.
void Forcing::linearized(double gradient_norm) {
  if (rule_ == ForcingRule::eisenstat_walker && previous_norm_ > 0) {
    constexpr double gamma = 0.9, alpha = 1.618033988749895, threshold = 0.1;
    const double guard = gamma * std::pow(relative_, alpha);
    const double next = gamma * std::pow(gradient_norm / previous_norm_, alpha);
    relative_ = std::min(t_, guard > threshold ? std::max(next, guard) : next);
  }
  previous_norm_ = gradient_norm;
}

InnerTolerance Forcing::tolerance() const {
  switch (rule_) {
    case ForcingRule::thesis:
      return {.relative_residual = t_, .by_norm = true};
    case ForcingRule::constant:
      return {.relative_residual = t_};
    case ForcingRule::eisenstat_walker:
      return {.relative_residual = relative_};
    case ForcingRule::nash_sofer:
      return {.model_decrease = t_};
  }
  return {};
}

}  // namespace raybundle
