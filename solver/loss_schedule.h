#pragma once

#include <raybundle/models/problem.h>
#include <raybundle/solver/options.h>

namespace raybundle {

/// The scale of a robust loss over a solve: from a wide one, which hardly tells outliers from the
/// errors of a bad start, halved down to the final one whenever the solve slows down (graduated
/// non-convexity [Blake87]). Without a wider start it is the final scale throughout.
class LossSchedule {
 public:
  /// `options` are resolved.
  explicit LossSchedule(const Options& options);

  double scale() const { return scale_; }  ///< pixels; 0 without a loss
  bool is_final() const { return scale_ <= final_; }

  /// An accepted step lowered the cost by this share of it. True when the scale became smaller.
  bool tighten(double relative_decrease);

 private:
  double scale_ = 0;
  double final_ = 0;
};

/// The scale to start with where the method graduates and the user did not say: residuals of the
/// start count as errors of the start, not as outliers, up to twice the median of any camera. A
/// camera whose every observation was beyond the loss would never come back.
double wide_start_scale(const Problem& problem, double loss_scale);

/// The loss that `options` (resolved) ask for, at its final scale.
RobustLoss robust_loss(const Options& options);

}  // namespace raybundle
