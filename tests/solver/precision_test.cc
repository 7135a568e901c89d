// Rows of the Jacobian in single precision: another rounding of the steps, the same minimum; and
// the guard that goes over to double precision.

#include <raybundle/solver/solve.h>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

Problem noisy(std::uint64_t seed) {
  return test::small_problem({.seed = seed, .points = 40, .far_points = 2});
}

TEST(PrecisionOfRows, LeadsToTheSameMinimum) {
  for (const Method method : {Method::lm_cholesky, Method::tnm, Method::dinm}) {
    Options options = {.method = method, .max_iterations = 200, .function_tolerance = 1e-12};
    options.precision = Precision::single_precision;
    Problem single = noisy(3), wide = noisy(3);
    const Summary a = solve(single, options);
    options.precision = Precision::double_precision;
    const Summary b = solve(wide, options);
    EXPECT_EQ(outcome(a.termination), Outcome::converged) << a.message;
    EXPECT_NEAR(a.final_cost, b.final_cost, 1e-8 * b.final_cost) << name(method);
    EXPECT_NE(a.iterations[1].cost, b.iterations[1].cost) << "the option has no effect";
  }
}

TEST(PrecisionOfRows, IsSingleUnlessToldOtherwise) {
  Problem problem = noisy(4), diagnosed = noisy(4);
  EXPECT_EQ(solve(problem, {}).options.precision, Precision::single_precision);
  const Summary summary = solve(diagnosed, {.diagnose = true});
  EXPECT_EQ(summary.options.precision, Precision::double_precision);
  EXPECT_EQ(summary.widened_at, -1);
}

// Steps that do nothing but fail: by itself a solve tries them in double precision before it gives
// up, once, and beyond what it would have ended with.
TEST(PrecisionOfRows, GuardsAgainstAModelThatDisagrees) {
  Options options = {.max_iterations = 100,
                     .function_tolerance = 0,
                     .gradient_tolerance = 0,
                     .parameter_tolerance = 0,
                     .max_consecutive_failures = 2,
                     .initial_damping = 1e-12};
  const auto start = [] { return test::small_problem({.seed = 4, .parameter_noise = 0.5}); };
  Problem guarded = start(), forced = start();
  const Summary a = solve(guarded, options);
  options.precision = Precision::single_precision;
  const Summary b = solve(forced, options);
  ASSERT_EQ(b.termination, Termination::consecutive_failures);
  EXPECT_EQ(b.widened_at, -1) << "was told to stay";
  const auto last = static_cast<int>(b.iterations.size()) - 1;
  EXPECT_EQ(a.widened_at, last);
  EXPECT_EQ(a.options.precision, Precision::double_precision);
  EXPECT_GT(a.iterations.size(), b.iterations.size());
  EXPECT_LE(a.final_cost, b.final_cost);
}

}  // namespace
}  // namespace raybundle
