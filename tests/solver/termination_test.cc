// Every way a solve can end is reached, by name, from a real problem.

#include <raybundle/solver/solve.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <gtest/gtest.h>

#include <raybundle/models/statistics.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

using test::small_problem;

constexpr Options never = {.max_iterations = 60,
                           .function_tolerance = 0,
                           .gradient_tolerance = 0,
                           .parameter_tolerance = 0};

TEST(TerminationOf, GradientAtAnExactStart) {
  Problem problem = small_problem({.seed = 1, .pixel_noise = 0, .parameter_noise = 0});
  const Problem before = problem;
  const Summary summary = solve(problem, {.gradient_tolerance = 1e-6});
  EXPECT_EQ(summary.termination, Termination::gradient_tolerance);
  EXPECT_EQ(summary.iterations.size(), 1U);
  EXPECT_EQ(problem.cameras, before.cameras);
  EXPECT_TRUE(summary.usable());
}

TEST(TerminationOf, GradientOnTheWay) {
  Problem problem = small_problem({.seed = 1, .pixel_noise = 0});
  Options options = never;
  options.gradient_tolerance = 1e-3;
  const Summary summary = solve(problem, options);
  EXPECT_EQ(summary.termination, Termination::gradient_tolerance);
  EXPECT_LE(summary.iterations.back().gradient_max, 1e-3);
  EXPECT_GT(summary.iterations[summary.iterations.size() - 2].gradient_max, 1e-3);
}

TEST(TerminationOf, Function) {
  Problem problem = small_problem({.seed = 2});
  const Summary summary = solve(problem, {.parameter_tolerance = 0});
  EXPECT_EQ(summary.termination, Termination::function_tolerance);
  EXPECT_EQ(outcome(summary.termination), Outcome::converged);
}

TEST(TerminationOf, Parameter) {
  Problem problem = small_problem({.seed = 2});
  Options options = never;
  options.parameter_tolerance = 1e-2;
  const Summary summary = solve(problem, options);
  EXPECT_EQ(summary.termination, Termination::parameter_tolerance);
  EXPECT_LE(summary.iterations.back().relative_step, 1e-2);
}

// A huge focal length dominates any norm of the whole state; its camera alone must not decide.
TEST(TerminationOf, ParameterIsNotFooledByAHugeFocalLength) {
  Problem problem = small_problem({.seed = 2});
  problem.cameras[6] *= 1e7;
  problem.cameras[7] = problem.cameras[8] = 0;
  problem.cameras[5] -= 5e7;
  Options options = never;
  options.parameter_tolerance = 1e-6;
  const Summary summary = solve(problem, options);
  EXPECT_GT(summary.iterations.size(), 3U);
  EXPECT_LT(summary.final_cost, 0.5 * summary.initial_cost);
}

TEST(TerminationOf, MaxIterations) {
  for (const int limit : {0, 1, 4}) {
    Problem problem = small_problem({.seed = 3, .parameter_noise = 0.1});
    Options options = never;
    options.max_iterations = limit;
    const Summary summary = solve(problem, options);
    EXPECT_EQ(summary.termination, Termination::max_iterations);
    EXPECT_EQ(summary.iterations.size(), static_cast<std::size_t>(limit) + 1);
    EXPECT_EQ(outcome(summary.termination), Outcome::limit_reached);
  }
}

TEST(TerminationOf, TimeLimitOfNothing) {
  Problem problem = small_problem({.seed = 3});
  const Problem before = problem;
  const Summary summary = solve(problem, {.time_limit = 0});
  EXPECT_EQ(summary.termination, Termination::time_limit);
  EXPECT_EQ(summary.iterations.size(), 1U);
  EXPECT_EQ(problem.points, before.points);
}

TEST(TerminationOf, Stopped) {
  Problem problem = small_problem({.seed = 3});
  const Summary summary = solve(problem, {}, [](const IterationRecord&) { return Control::stop; });
  EXPECT_EQ(summary.termination, Termination::stopped);
}

// At the minimum, to the last bit: no step lowers the cost any more.
Problem solved() {
  Problem problem = small_problem({.seed = 4});
  Options options = never;
  options.max_consecutive_failures = 60;
  (void)solve(problem, options);
  return problem;
}

TEST(TerminationOf, DampingLimit) {
  Problem problem = small_problem({.seed = 4, .parameter_noise = 0.5});
  Options options = never;
  options.max_consecutive_failures = 1000;
  options.initial_damping = 1e-12;
  options.max_damping = 1e-11;  // the first failures already pass it
  const Summary summary = solve(problem, options);
  EXPECT_EQ(summary.termination, Termination::damping_limit);
  EXPECT_EQ(outcome(summary.termination), Outcome::failed);
  EXPECT_LE(summary.final_cost, summary.initial_cost);
}

TEST(TerminationOf, ConsecutiveFailures) {
  Problem problem = small_problem({.seed = 4, .parameter_noise = 0.5});
  Options options = never;
  options.max_consecutive_failures = 2;
  options.initial_damping = 1e-12;
  options.precision = Precision::double_precision;  // else it would get a second chance
  const Summary summary = solve(problem, options);
  EXPECT_EQ(summary.termination, Termination::consecutive_failures);
  const std::size_t size = summary.iterations.size();
  ASSERT_GE(size, 3U);
  EXPECT_FALSE(summary.iterations[size - 1].accepted);
  EXPECT_FALSE(summary.iterations[size - 2].accepted);
  EXPECT_TRUE(summary.iterations[size - 3].accepted);
}

// With all tolerances at zero a solve at the minimum ends all the same, converged, not failed.
TEST(TerminationOf, TheMinimumWithoutTolerancesIsConvergence) {
  Problem problem = solved();
  Options options = never;
  options.max_iterations = 1000;
  const Summary summary = solve(problem, options);
  EXPECT_EQ(outcome(summary.termination), Outcome::converged) << name(summary.termination);
  EXPECT_LT(summary.iterations.size(), 100U);
}

// Puts the first observation's camera at rest so that the point it sees has z exactly 0.
Problem with_point_in_camera_plane() {
  Problem problem = small_problem({.seed = 5});
  const auto j = static_cast<std::size_t>(problem.observation_camera[0]);
  const auto i = static_cast<std::size_t>(problem.observation_point[0]);
  std::fill_n(problem.cameras.begin() + static_cast<std::ptrdiff_t>(9 * j), 6, 0.0);
  problem.points[3 * i + 2] = 0;
  return problem;
}

TEST(TerminationOf, BadStartWithAPointInTheCameraPlane) {
  for (const Method method : {Method::lm_cholesky, Method::tnm}) {
    for (const Elimination elimination :
         {Elimination::none, Elimination::points, Elimination::cameras}) {
      Problem problem = with_point_in_camera_plane();
      const Problem before = problem;
      const Summary summary = solve(problem, {.method = method, .elimination = elimination});
      EXPECT_EQ(summary.termination, Termination::bad_start);
      EXPECT_EQ(outcome(summary.termination), Outcome::failed);
      EXPECT_FALSE(summary.usable());
      EXPECT_EQ(problem.cameras, before.cameras);
      EXPECT_EQ(summary.iterations.size(), 1U);
    }
  }
}

TEST(TerminationOf, BadStartWithOverflowInTheGradientOnly) {
  Problem problem = small_problem({.seed = 5});
  // The cost still fits, its derivative by k2 does not.
  for (double& b : problem.observations) b = 1e150;
  const double f = 1e150;
  for (std::size_t j = 6; j < problem.cameras.size(); j += 9) problem.cameras[j] = f;
  const double cost = reprojection_statistics(problem).cost;
  ASSERT_TRUE(std::isfinite(cost));
  const Summary summary = solve(problem);
  EXPECT_EQ(outcome(summary.termination) == Outcome::failed, true) << name(summary.termination);
  EXPECT_LE(summary.final_cost, summary.initial_cost);
}

// Points behind cameras, far and near: legal, and no reason to break.
TEST(TerminationOf, PointsBehindCamerasAreSolved) {
  Problem problem = small_problem({.seed = 6});
  for (std::size_t k = 0; k < 9; ++k) problem.points[k] *= -20;
  const Summary summary = solve(problem);
  EXPECT_TRUE(std::isfinite(summary.final_cost));
  EXPECT_LT(summary.final_cost, summary.initial_cost);
}

// Candidates that cannot be projected are rejections like any other.
TEST(TerminationOf, CandidatesThatAreNotFiniteAreRejected) {
  Problem problem = small_problem({.seed = 7});
  Options options = never;
  options.initial_damping = 1e-30;
  options.min_damping = 1e-30;
  for (std::size_t k = 0; k < 3; ++k) problem.points[k] *= 1e12;  // nearly no information
  const Summary summary = solve(problem, options);
  EXPECT_TRUE(std::isfinite(summary.final_cost));
  EXPECT_LE(summary.final_cost, summary.initial_cost);
  for (const double x : problem.points) EXPECT_TRUE(std::isfinite(x));
  for (const double x : problem.cameras) EXPECT_TRUE(std::isfinite(x));
}

}  // namespace
}  // namespace raybundle
