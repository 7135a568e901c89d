#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace raybundle::test {

/// The order of the remainder |F(tau) - F(0) - tau F'(0)| in tau, measured on tau = 1/2, 1/4, ...
/// [Qu18, Eq. 3.39-3.41]: 2 when `derivative` is F'(0), 1 when it is wrong.
/// `along` maps tau to F(u + tau du) (or F of any smooth curve through u), an Eigen vector.
/// Only steps whose remainder stands well clear of rounding are used, the smallest six of them;
/// returns infinity when the remainder is nothing but rounding (F is linear along the curve), and
/// NaN when there are too few steps to tell.
template <class Curve>
double taylor_slope(const Curve& along, const Eigen::VectorXd& derivative) {
  const Eigen::VectorXd f0 = along(0.0);
  std::vector<double> log_remainder;
  for (int k = 1; k <= 40; ++k) {
    const double tau = std::ldexp(1.0, -k);
    const Eigen::VectorXd f = along(tau);
    const double remainder = (f - f0 - tau * derivative).norm();
    const double rounding = 1e-15 * (f0.norm() + f.norm());
    if (!(remainder > 1e3 * rounding)) break;
    log_remainder.push_back(std::log2(remainder));
  }
  if (log_remainder.empty()) return std::numeric_limits<double>::infinity();
  const std::size_t last = log_remainder.size() - 1;
  const std::size_t steps = std::min<std::size_t>(last, 5);
  if (steps < 2) return std::numeric_limits<double>::quiet_NaN();
  return (log_remainder[last - steps] - log_remainder[last]) / static_cast<double>(steps);
}

/// Succeeds when the Taylor remainder along a curve has order 2 (or vanishes).
template <class Curve>
::testing::AssertionResult has_taylor_slope_two(const Curve& along,
                                                const Eigen::VectorXd& derivative,
                                                double tolerance = 0.1) {
  const double slope = taylor_slope(along, derivative);
  if (slope >= 2 - tolerance) return ::testing::AssertionSuccess() << "slope " << slope;
  return ::testing::AssertionFailure() << "Taylor remainder of order " << slope << ", expected 2";
}

}  // namespace raybundle::test
