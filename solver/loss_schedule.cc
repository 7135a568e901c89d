#include <raybundle/solver/loss_schedule.h>

#include <raybundle/models/statistics.h>

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

constexpr double slow = 0.05;  // a decrease by less of the cost: this scale has done its work

}  // namespace

LossSchedule::LossSchedule(const Options& options) {
  if (*options.loss == Loss::none) return;
  final_ = *options.loss_scale;
  scale_ = options.loss_start_scale.value_or(final_);
}

bool LossSchedule::tighten(double relative_decrease) {
  if (is_final() || relative_decrease > slow) return false;
  scale_ = std::max(final_, 0.5 * scale_);
  return true;
}

double wide_start_scale(const Problem& problem, double loss_scale) {
  double widest = 0;
  for (const double median : median_residuals(problem)) {
    if (std::isfinite(median)) widest = std::max(widest, median);
  }
  return std::clamp(2 * widest, loss_scale, std::max(1e100, loss_scale));
}

RobustLoss robust_loss(const Options& options) {
  if (*options.loss == Loss::none) return {};
  return {*options.loss, *options.loss_scope, *options.loss_scale};
}

}  // namespace raybundle
