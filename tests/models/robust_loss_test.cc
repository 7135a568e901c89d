// Loss functions on their own: definitions, derivatives, limits, and what happens at the edges of
// the numbers.

#include <raybundle/models/robust_loss.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/error.h>

namespace raybundle {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

/// rho as the books print it.
double definition(Loss kind, double c, double s) {
  const double x = s / (c * c);
  switch (kind) {
    case Loss::none:
      return s;
    case Loss::huber:  // twice [Qu18, Eq. 4.21]
      return std::sqrt(s) <= c ? s : 2 * c * (std::sqrt(s) - c / 2);
    case Loss::soft_l1:
      return 2 * c * c * (std::sqrt(1 + x) - 1);
    case Loss::cauchy:
      return c * c * std::log(1 + x);
    case Loss::geman_mcclure:
      return s / (1 + x);
    case Loss::tukey:
      return c * c / 3 * (x < 1 ? 1 - std::pow(1 - x, 3) : 1);
    case Loss::truncated:  // twice [Qu18, Eq. 4.22]
      return std::fmin(s, c * c);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

std::string name_of(Loss kind) {
  const char* const names[] = {"None",         "Huber", "SoftL1",   "Cauchy",
                               "GemanMcClure", "Tukey", "Truncated"};
  return names[static_cast<int>(kind)];
}

class EachLoss : public ::testing::TestWithParam<Loss> {
 protected:
  RobustLoss loss(double scale) const { return {.kind = GetParam(), .scale = scale}; }
  bool has_cut() const { return GetParam() == Loss::tukey || GetParam() == Loss::truncated; }
};

const std::vector<double> scales = {0.3, 1, 2.5, 1e3};
const std::vector<double> relative = {0,   1e-9, 1e-4, 0.1, 0.5, 0.9, 0.999,
                                      1.1, 2,    10,   1e3, 1e6, 1e12};

TEST_P(EachLoss, IsItsDefinition) {
  for (const double c : scales) {
    for (const double x : relative) {
      const double s = x * c * c;
      const double rho = evaluate(loss(c), s).rho;
      EXPECT_NEAR(rho, definition(GetParam(), c, s), 1e-15 * c * c + 1e-14 * rho) << c << " " << x;
    }
  }
}

TEST_P(EachLoss, StartsAsThePlainSquare) {
  for (const double c : scales) {
    EXPECT_EQ(evaluate(loss(c), 0).rho, 0);
    EXPECT_EQ(evaluate(loss(c), 0).weight, 1);
    // No digits are lost far inside.
    EXPECT_NEAR(evaluate(loss(c), 1e-20 * c * c).rho, 1e-20 * c * c, 1e-34 * c * c);
  }
}

TEST_P(EachLoss, WeightIsTheDerivative) {
  for (const double c : scales) {
    for (const double x : {1e-4, 0.1, 0.5, 0.9, 1.1, 2.0, 10.0, 1e3}) {
      const double s = x * c * c, h = 1e-4 * s;
      const auto rho = [&](double at) { return evaluate(loss(c), at).rho; };
      const double slope =
          (8 * (rho(s + h) - rho(s - h)) - (rho(s + 2 * h) - rho(s - 2 * h))) / (12 * h);
      EXPECT_NEAR(evaluate(loss(c), s).weight, slope, 1e-9) << c << " " << x;
    }
  }
}

TEST_P(EachLoss, IsContinuousAtTheScale) {
  for (const double c : scales) {
    const LossValue below = evaluate(loss(c), c * c * (1 - 1e-12));
    const LossValue above = evaluate(loss(c), c * c * (1 + 1e-12));
    EXPECT_NEAR(below.rho, above.rho, 1e-11 * c * c);
    if (GetParam() == Loss::truncated) continue;  // its weight jumps
    EXPECT_NEAR(below.weight, above.weight, 1e-11);
  }
}

// rho is concave: the tangent in s lies above it everywhere, which is why an IRLS step that lowers
// the weighted squares lowers the cost.
TEST_P(EachLoss, TangentMajorises) {
  const double c = 1.7;
  for (const double x0 : relative) {
    const double s0 = x0 * c * c;
    const LossValue at = evaluate(loss(c), s0);
    for (const double x : relative) {
      const double s = x * c * c;
      const double bound = at.rho + at.weight * (s - s0);
      const double rounding = 1e-15 * (at.rho + at.weight * (s + s0));
      EXPECT_LE(evaluate(loss(c), s).rho, bound + 4 * rounding) << x0 << " " << x;
    }
  }
}

TEST_P(EachLoss, WeightsAreSharesOfOne) {
  for (const double x : relative) {
    const double weight = evaluate(loss(2), 4 * x).weight;
    EXPECT_GE(weight, 0);
    EXPECT_LE(weight, 1);
    if (has_cut() && x > 1) {
      EXPECT_EQ(weight, 0);
    } else {
      EXPECT_GT(weight, 0);
    }
  }
}

TEST_P(EachLoss, WideScaleIsNoLoss) {
  EXPECT_NEAR(evaluate(loss(1e6), 3).rho, 3, 1e-11);
  EXPECT_NEAR(evaluate(loss(1e6), 3).weight, 1, 1e-11);
}

TEST_P(EachLoss, WhatIsNotFiniteStaysSo) {
  for (const double s : {inf, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_FALSE(std::isfinite(evaluate(loss(1), s).rho));
    EXPECT_FALSE(std::isfinite(evaluate(loss(1), s).weight));
  }
}

TEST_P(EachLoss, HugeSquaresKeepAFiniteValueAndWeight) {
  for (const double c : {1e-100, 1e-3, 1.0, 1e100}) {
    for (const double s : {1e-100, 1e200, 1e250}) {
      if (s / (c * c) > 1e300) continue;
      const LossValue value = evaluate(loss(c), s);
      EXPECT_TRUE(std::isfinite(value.rho)) << c << " " << s;
      EXPECT_GT(value.rho, 0) << c << " " << s;
      EXPECT_TRUE(value.weight >= 0 && value.weight <= 1) << c << " " << s;
    }
  }
}

// Sums and weights of rows against one value at a time.
TEST_P(EachLoss, LevelsOffWhereItIsBounded) {
  const RobustLoss loss = {GetParam(), LossScope::observation, 2};
  EXPECT_EQ(levels_off(GetParam()), evaluate(loss, 1e100).rho <= 4);
}

TEST_P(EachLoss, RowsFollowTheScope) {
  const std::vector<double> r = {0.1, -0.2, 0.9, 0.9, -1.2, 0.01, 30, -40};
  const auto value = [&](double s) { return evaluate(loss(1), s); };
  for (const LossScope scope : {LossScope::observation, LossScope::component}) {
    RobustLoss scoped = loss(1);
    scoped.scope = scope;
    std::vector<double> root(r.size());
    double expected = 0;
    const double sum = robust_weights(scoped, r.data(), 4, 2, root.data());
    for (std::size_t i = 0; i < r.size(); i += 2) {
      const double x = r[i] * r[i], y = r[i + 1] * r[i + 1];
      const bool whole = scope == LossScope::observation;
      expected += whole ? value(x + y).rho : value(x).rho + value(y).rho;
      EXPECT_DOUBLE_EQ(root[i] * root[i], value(whole ? x + y : x).weight);
      EXPECT_DOUBLE_EQ(root[i + 1] * root[i + 1], value(whole ? x + y : y).weight);
    }
    EXPECT_DOUBLE_EQ(sum, expected);
    EXPECT_EQ(robust_sum(scoped, r.data(), 4), sum);
  }
}

INSTANTIATE_TEST_SUITE_P(Losses, EachLoss,
                         ::testing::Values(Loss::none, Loss::huber, Loss::soft_l1, Loss::cauchy,
                                           Loss::geman_mcclure, Loss::tukey, Loss::truncated),
                         [](const auto& test) { return name_of(test.param); });

TEST(RobustLoss, ScaleIsAPositiveLength) {
  for (const double scale : {0.0, -1.0, inf, std::nan(""), 1e-200}) {
    EXPECT_THROW(validate(RobustLoss{.kind = Loss::huber, .scale = scale}), InputError) << scale;
  }
  EXPECT_NO_THROW(validate(RobustLoss{}));
}

TEST(RobustLoss, AFactorOfZeroLeavesZeros) {
  std::vector<double> values = {1, inf, 2, 3, std::nan(""), -1};
  const std::vector<double> factor = {0, 0.5, 0};
  scale_rows(factor.data(), 3, 2, values.data());
  EXPECT_EQ(values, (std::vector<double>{0, 0, 1, 1.5, 0, 0}));
}

}  // namespace
}  // namespace raybundle
