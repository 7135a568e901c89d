// Radius, forcing and loss schedule one by one, on verdicts made by hand.

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <raybundle/solver/forcing.h>
#include <raybundle/solver/loss_schedule.h>
#include <raybundle/solver/trust_radius.h>

namespace raybundle {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

double radius_after(double rho, bool on_boundary, double length, double radius = 8) {
  TrustRadius region(radius);
  region.update(rho, on_boundary, length);
  return region.radius();
}

TEST(TrustRadius, FollowsTheRatio) {  // [Qu18, Alg. 2]
  EXPECT_EQ(radius_after(0.9, true, 8), 16);
  EXPECT_EQ(radius_after(0.75, true, 8), 8) << "above 0.75 only";
  EXPECT_EQ(radius_after(0.9, false, 3), 8) << "a step from inside says nothing about the region";
  EXPECT_EQ(radius_after(0.5, true, 8), 8);
  EXPECT_EQ(radius_after(0.25, true, 8), 8);
  EXPECT_EQ(radius_after(0.2, true, 8), 2);
  EXPECT_EQ(radius_after(-3, true, 8), 2);
  EXPECT_EQ(radius_after(nan, true, 8), 2);
}

TEST(TrustRadius, AFailureFromInsideExcludesItsStep) {
  EXPECT_EQ(radius_after(-1, false, 1), 0.25);
  EXPECT_EQ(radius_after(nan, false, 0), 2) << "no step at all";
  EXPECT_EQ(radius_after(nan, false, nan), 2) << "or none that can be measured";
}

TEST(TrustRadius, TheFirstStepSetsTheScale) {
  TrustRadius region(std::nullopt);
  EXPECT_EQ(region.radius(), inf);
  region.update(nan, false, 0);
  EXPECT_EQ(region.radius(), inf) << "nothing was learnt";
  region.update(0.9, false, 5);
  EXPECT_EQ(region.radius(), 5);
  TrustRadius bad(std::nullopt);
  bad.update(-1, false, 5);
  EXPECT_EQ(bad.radius(), 1.25);
}

TEST(Forcing, ConstantRules) {
  Forcing thesis(ForcingRule::thesis, 0.2), constant(ForcingRule::constant, 0.3),
      nash(ForcingRule::nash_sofer, 0.4);
  for (const double norm : {10.0, 1.0, 100.0}) {
    for (Forcing* forcing : {&thesis, &constant, &nash}) forcing->linearized(norm);
    EXPECT_EQ(thesis.tolerance().relative_residual, 0.2);
    EXPECT_TRUE(thesis.tolerance().by_norm);
    EXPECT_EQ(constant.tolerance().relative_residual, 0.3);
    EXPECT_FALSE(constant.tolerance().by_norm);
    EXPECT_EQ(nash.tolerance().relative_residual, 0);
    EXPECT_EQ(nash.tolerance().model_decrease, 0.4);
  }
}

TEST(Forcing, EisenstatWalkerFollowsTheGradient) {
  const double golden = 0.5 * (1 + std::sqrt(5.0));
  Forcing forcing(ForcingRule::eisenstat_walker, 0.5);
  forcing.linearized(100);
  EXPECT_EQ(forcing.tolerance().relative_residual, 0.5) << "nothing to compare with";
  forcing.linearized(1);  // the guard, 0.9 * 0.5^golden, is above its threshold
  const double guarded = 0.9 * std::pow(0.5, golden);
  EXPECT_NEAR(forcing.tolerance().relative_residual, guarded, 1e-12);
  forcing.linearized(0.1);
  const double again = 0.9 * std::pow(guarded, golden);
  EXPECT_NEAR(forcing.tolerance().relative_residual, again, 1e-12);
  forcing.linearized(0.01);  // by now it is below
  EXPECT_NEAR(forcing.tolerance().relative_residual, 0.9 * std::pow(0.1, golden), 1e-12);
  forcing.linearized(50);
  EXPECT_EQ(forcing.tolerance().relative_residual, 0.5) << "never looser than t";
}

Options huber(std::optional<double> start) {
  return resolve({.loss = Loss::huber, .loss_scale = 2, .loss_start_scale = start});
}

TEST(LossSchedule, HalvesDownToTheFinalScaleWhenTheSolveSlowsDown) {
  LossSchedule schedule(huber(10.0));
  EXPECT_EQ(schedule.scale(), 10);
  EXPECT_FALSE(schedule.tighten(0.5)) << "still gaining";
  EXPECT_EQ(schedule.scale(), 10);
  for (const double expected : {5.0, 2.5, 2.0}) {
    EXPECT_FALSE(schedule.is_final());
    EXPECT_TRUE(schedule.tighten(0.01));
    EXPECT_EQ(schedule.scale(), expected);
  }
  EXPECT_TRUE(schedule.is_final());
  EXPECT_FALSE(schedule.tighten(0));
}

TEST(LossSchedule, WithoutAWiderStartThereIsNothingToTighten) {
  EXPECT_TRUE(LossSchedule(huber(std::nullopt)).is_final());
  EXPECT_EQ(LossSchedule(huber(std::nullopt)).scale(), 2);
  EXPECT_TRUE(LossSchedule(resolve({})).is_final());
  EXPECT_EQ(LossSchedule(resolve({})).scale(), 0);
  EXPECT_EQ(robust_loss(resolve({})).kind, Loss::none);
  EXPECT_EQ(robust_loss(huber(10.0)).scale, 2);
}

}  // namespace
}  // namespace raybundle
