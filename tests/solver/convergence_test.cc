// The stop tests one by one, on records made by hand.

#include <raybundle/solver/convergence.h>

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include <raybundle/solver/option_table.h>

namespace raybundle {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t residuals = 1000;
constexpr double inf = std::numeric_limits<double>::infinity();

constexpr std::array all = {Termination::gradient_tolerance,   Termination::function_tolerance,
                            Termination::parameter_tolerance,  Termination::max_iterations,
                            Termination::time_limit,           Termination::stopped,
                            Termination::damping_limit,        Termination::radius_limit,
                            Termination::consecutive_failures, Termination::bad_start,
                            Termination::out_of_memory};

constexpr Convergence::Situation at_100 = {.previous_cost = 100, .next_damping = 1};

// An accepted step that moved and helped: no reason to stop.
IterationRecord good_step() {
  IterationRecord record;
  record.iteration = 1;
  record.accepted = true;
  record.cost = record.candidate_cost = 90;
  record.predicted_decrease = 10;
  record.gradient_max = record.gradient_norm = 5;
  record.relative_step = record.step_norm = 0.1;
  record.rho = 1;
  return record;
}

IterationRecord rejected_step() {
  IterationRecord record = good_step();
  record.accepted = false;
  record.cost = 100;
  record.candidate_cost = 120;
  record.rho = -2;
  return record;
}

// A factorisation that failed leaves nothing to judge.
IterationRecord failed_step() {
  IterationRecord record = rejected_step();
  record.candidate_cost = record.rho = nan;
  record.predicted_decrease = record.relative_step = record.step_norm = 0;
  return record;
}

std::optional<Termination> verdict(const IterationRecord& record, const Options& options = {},
                                   double next_damping = 1) {
  Convergence convergence(resolve(options), residuals);
  const auto found = convergence.test(record, {.previous_cost = 100, .next_damping = next_damping});
  return found ? found : convergence.limit(record);
}

TEST(Convergence, GoesOnAfterAGoodStep) { EXPECT_EQ(verdict(good_step()), std::nullopt); }

TEST(Convergence, GradientByItsLargestEntry) {
  IterationRecord record = good_step();
  record.gradient_max = 1e-3;
  record.gradient_norm = 1;  // of very many entries
  EXPECT_EQ(verdict(record, {.gradient_tolerance = 1e-3}), Termination::gradient_tolerance);
  EXPECT_EQ(verdict(record, {.gradient_tolerance = 0.999e-3}), std::nullopt);
  record.iteration = 0;
  EXPECT_EQ(verdict(record, {.gradient_tolerance = 1e-3}), Termination::gradient_tolerance);
  record.gradient_max = nan;
  EXPECT_EQ(verdict(record, {.gradient_tolerance = 1e300}), std::nullopt);
}

TEST(Convergence, RelativeDecreaseOfTheCost) {
  IterationRecord record = good_step();
  record.cost = record.candidate_cost = 100 - 1e-4;
  record.predicted_decrease = 1e-4;
  EXPECT_EQ(verdict(record, {.function_tolerance = 1.001e-6}), Termination::function_tolerance);
  EXPECT_EQ(verdict(record, {.function_tolerance = 0.999e-6}), std::nullopt);
}

TEST(Convergence, TheStartIsNotAStep) {
  IterationRecord record = good_step();
  record.iteration = 0;
  record.relative_step = 0;
  record.cost = 100;  // as large as "before"
  EXPECT_EQ(verdict(record), std::nullopt);
}

TEST(Convergence, RelativeStep) {
  IterationRecord record = good_step();
  record.relative_step = 1e-5;
  EXPECT_EQ(verdict(record, {.parameter_tolerance = 1e-5}), Termination::parameter_tolerance);
  EXPECT_EQ(verdict(record, {.parameter_tolerance = 0.99e-5}), std::nullopt);
}

TEST(Convergence, ARejectedStepOfNoConsequenceConverges) {
  IterationRecord record = rejected_step();
  record.candidate_cost = 100 + 5e-5;
  record.predicted_decrease = 5e-5;
  EXPECT_EQ(verdict(record, {.function_tolerance = 1e-6}), Termination::function_tolerance);
  record.predicted_decrease = 10;  // the model still promises much
  EXPECT_EQ(verdict(record, {.function_tolerance = 1e-6}), std::nullopt);
  record.predicted_decrease = 5e-5;
  record.candidate_cost = 120;  // and the cost is far from flat
  EXPECT_EQ(verdict(record, {.function_tolerance = 1e-6}), std::nullopt);
}

// After several failures the damping alone makes the model promise little: that is no minimum.
TEST(Convergence, LaterFailuresDoNotPassForConvergence) {
  Convergence convergence(resolve({.function_tolerance = 1e-6}), residuals);
  EXPECT_EQ(convergence.test(rejected_step(), at_100), std::nullopt);
  IterationRecord record = rejected_step();
  record.candidate_cost = 100 + 5e-5;
  record.predicted_decrease = 5e-5;
  EXPECT_EQ(convergence.test(record, at_100), std::nullopt);
  record.candidate_cost = 100 + 1e-14;  // what rounding leaves of the cost decides
  record.predicted_decrease = 1e-14;
  EXPECT_EQ(convergence.test(record, at_100), Termination::function_tolerance);
}

// Whatever made a step small, there is no convergence while the free model still promises much.
TEST(Convergence, AShortenedStepIsNoConvergence) {
  const Options options = resolve({.function_tolerance = 1e-6, .parameter_tolerance = 1e-6});
  const auto test = [&](const IterationRecord& record, double promise) {
    return Convergence(options, residuals).test(record, {.previous_cost = 100, .promise = promise});
  };
  IterationRecord record = good_step();
  record.cost = record.candidate_cost = 100 - 1e-9;
  record.relative_step = 1e-9;
  EXPECT_EQ(test(record, 0), Termination::function_tolerance);
  EXPECT_EQ(test(record, 0.99e-4), Termination::function_tolerance);
  EXPECT_EQ(test(record, 1.01e-4), std::nullopt) << "damped";
  record.on_boundary = true;
  EXPECT_EQ(test(record, 0), std::nullopt) << "cut by the region";
  record.on_boundary = false;
  record.inner_capped = true;
  EXPECT_EQ(test(record, 0), std::nullopt) << "not solved to its tolerance";
  record.inner_capped = false;
  Convergence convergence(options, residuals);
  EXPECT_EQ(convergence.test(rejected_step(), at_100), std::nullopt);
  EXPECT_EQ(convergence.test(record, at_100), std::nullopt) << "a failure has just raised damping";
  EXPECT_EQ(convergence.test(record, at_100), Termination::function_tolerance);
  IterationRecord rejected = rejected_step();
  rejected.candidate_cost = 100 + 1e-14;
  rejected.predicted_decrease = 1e-14;
  EXPECT_EQ(test(rejected, 0), Termination::function_tolerance);
  EXPECT_EQ(test(rejected, 1.01e-4), std::nullopt);
}

TEST(Convergence, AFailedFactorisationIsNotConvergence) {
  EXPECT_EQ(verdict(failed_step(), {.function_tolerance = 1, .parameter_tolerance = 1}),
            std::nullopt);
  IterationRecord record = rejected_step();
  record.candidate_cost = inf;
  record.relative_step = 0;
  record.predicted_decrease = 0;
  EXPECT_EQ(verdict(record, {.function_tolerance = 1, .parameter_tolerance = 1}), std::nullopt);
}

TEST(Convergence, DampingAtItsLimit) {
  EXPECT_EQ(verdict(rejected_step(), {.max_damping = 1e6}, 1.1e6), Termination::damping_limit);
  EXPECT_EQ(verdict(rejected_step(), {.max_damping = 1e6}, 1e6), std::nullopt);
  EXPECT_EQ(verdict(failed_step(), {.max_damping = 1e6}, inf), Termination::damping_limit);
  EXPECT_EQ(verdict(good_step(), {.max_damping = 1e6}, 2e6), std::nullopt)
      << "an accepted step is no failure";
}

TEST(Convergence, RadiusAtItsLimit) {
  const auto at = [](double radius, const IterationRecord& record) {
    return Convergence(resolve({.method = Method::inm, .min_radius = 1e-6}), residuals)
        .test(record, {.previous_cost = 100, .next_radius = radius});
  };
  EXPECT_EQ(at(0.9e-6, rejected_step()), Termination::radius_limit);
  EXPECT_EQ(at(1e-6, rejected_step()), std::nullopt);
  EXPECT_EQ(at(0.9e-6, failed_step()), Termination::radius_limit);
  EXPECT_EQ(at(0.9e-6, good_step()), std::nullopt) << "an accepted step is progress";
}

TEST(Convergence, FailuresCountInARowOnly) {
  Convergence convergence(resolve({.max_consecutive_failures = 3}), residuals);
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(convergence.test(rejected_step(), at_100), std::nullopt);
    EXPECT_EQ(convergence.test(failed_step(), at_100), std::nullopt);
    if (round == 1) break;
    EXPECT_EQ(convergence.test(good_step(), at_100), std::nullopt);
  }
  EXPECT_EQ(convergence.test(rejected_step(), at_100), Termination::consecutive_failures);
}

TEST(Convergence, Limits) {
  IterationRecord record = good_step();
  record.iteration = 7;
  record.seconds = 2;
  EXPECT_EQ(verdict(record, {.max_iterations = 7}), Termination::max_iterations);
  EXPECT_EQ(verdict(record, {.max_iterations = 8}), std::nullopt);
  EXPECT_EQ(verdict(record, {.time_limit = 2}), Termination::time_limit);
  EXPECT_EQ(verdict(record, {.time_limit = 2.1}), std::nullopt);
  record.iteration = 0;
  EXPECT_EQ(verdict(record, {.max_iterations = 0}), Termination::max_iterations);
  record.gradient_max = 0;  // convergence is the better news
  EXPECT_EQ(verdict(record, {.max_iterations = 0}), Termination::gradient_tolerance);
}

TEST(Termination, NamesOutcomesAndReasons) {
  Summary summary;
  summary.iterations.push_back(good_step());
  std::set<std::string> names, reasons;
  for (const Termination value : all) {
    EXPECT_TRUE(names.insert(name(value)).second) << name(value);
    const std::string reason = Convergence::explain(value, summary);
    EXPECT_FALSE(reason.empty()) << name(value);
    EXPECT_TRUE(reasons.insert(reason).second) << reason;
    const Outcome kind = outcome(value);
    EXPECT_EQ(reason.rfind("converged", 0) == 0, kind == Outcome::converged) << reason;
    EXPECT_EQ(reason.rfind("failed", 0) == 0, kind == Outcome::failed) << reason;
    EXPECT_EQ(reason.rfind("limit", 0) == 0, kind == Outcome::limit_reached) << reason;
    summary.termination = value;
    EXPECT_EQ(summary.usable(), kind != Outcome::failed);
  }
  EXPECT_EQ(outcome(Termination::stopped), Outcome::interrupted);
  EXPECT_STREQ(name(Termination::gradient_tolerance), "gradient_tolerance");
  EXPECT_STREQ(name(Termination::bad_start), "bad_start");
  EXPECT_STREQ(name(Termination::out_of_memory), "out_of_memory");
}

}  // namespace
}  // namespace raybundle
