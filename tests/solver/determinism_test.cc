// The same input, options and build give the same bits, whatever the number of threads.

#include <raybundle/solver/solve.h>

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }

// Large enough for the loops over rows and blocks to be cut into several pieces.
Problem problem_to_solve() {
  return test::small_problem({.seed = 31,
                              .cameras = 12,
                              .points = 700,
                              .observations_per_point = 4,
                              .duplicate_observations = 20,
                              .unobserved_cameras = 1,
                              .unobserved_points = 3,
                              .points_seen_once = 20,
                              .far_points = 5,
                              .parameter_noise = 0.1,
                              .shuffled = true});
}

void expect_same(const IterationRecord& a, const IterationRecord& b) {
  EXPECT_EQ(a.iteration, b.iteration);
  EXPECT_EQ(a.accepted, b.accepted);
  EXPECT_EQ(a.inner_iterations, b.inner_iterations);
  EXPECT_EQ(a.eliminated, b.eliminated);
  EXPECT_EQ(a.on_boundary, b.on_boundary);
  EXPECT_EQ(a.inner_capped, b.inner_capped);
  const auto numbers = [](const IterationRecord& r) {
    return std::array{bits(r.cost),
                      bits(r.candidate_cost),
                      bits(r.predicted_decrease),
                      bits(r.gradient_norm),
                      bits(r.gradient_max),
                      bits(r.step_norm),
                      bits(r.relative_step),
                      bits(r.rho),
                      bits(r.damping),
                      bits(r.radius),
                      bits(r.condition_cameras),
                      bits(r.condition_points),
                      bits(r.loss_scale)};
  };
  EXPECT_EQ(numbers(a), numbers(b)) << "iteration " << a.iteration;
}

struct Solved {
  Problem problem;
  Summary summary;
};

Solved solve_with(int threads, Options options) {
  options.threads = threads;
  Solved solved{problem_to_solve(), {}};
  solved.summary = solve(solved.problem, options);
  return solved;
}

using Variant = std::tuple<Options, std::string>;

Options tnm(Elimination elimination) {
  return {.method = Method::tnm, .elimination = elimination, .max_iterations = 6};
}
Options cholesky(Elimination elimination, Linear linear, int iterations) {
  return {.elimination = elimination, .linear = linear, .max_iterations = iterations};
}

std::vector<Variant> variants() {
  return {
      {cholesky(Elimination::points, Linear::dense_cholesky, 8), "CholeskyPointsDense"},
      {cholesky(Elimination::points, Linear::sparse_cholesky, 8), "CholeskyPointsSparse"},
      {cholesky(Elimination::points, Linear::cholmod, 8), "CholeskyPointsCholmod"},
      {cholesky(Elimination::none, Linear::sparse_cholesky, 3), "CholeskyNoneSparse"},
      {cholesky(Elimination::cameras, Linear::dense_cholesky, 2), "CholeskyCamerasDense"},
      {tnm(Elimination::points), "PcgPoints"},
      {{.method = Method::tnm, .linear = Linear::explicit_pcg, .max_iterations = 6}, "PcgExplicit"},
      {tnm(Elimination::none), "PcgNone"},
      {tnm(Elimination::cameras), "PcgCameras"},
      {{.method = Method::inm, .max_iterations = 8}, "Inm"},
      {{.method = Method::adinm, .max_iterations = 8}, "Adinm"},
      {{.method = Method::irls, .max_iterations = 12}, "Irls"},
      {{.method = Method::dinm, .max_iterations = 8, .forcing_rule = ForcingRule::nash_sofer},
       "DinmNashSofer"}};
}

class Determinism : public ::testing::TestWithParam<Variant> {};

TEST_P(Determinism, SameBitsForOneTwoAndThreeThreads) {
  const Solved one = solve_with(1, std::get<0>(GetParam()));
  EXPECT_EQ(one.summary.threads, 1);
  for (const int threads : {2, 3}) {
    const Solved many = solve_with(threads, std::get<0>(GetParam()));
    EXPECT_EQ(many.summary.threads, threads);
    EXPECT_EQ(one.problem.cameras, many.problem.cameras) << threads;
    EXPECT_EQ(one.problem.points, many.problem.points) << threads;
    EXPECT_EQ(one.summary.termination, many.summary.termination);
    EXPECT_EQ(one.summary.message, many.summary.message);
    EXPECT_EQ(one.summary.linear_solver, many.summary.linear_solver);
    EXPECT_EQ(bits(one.summary.final_cost), bits(many.summary.final_cost));
    ASSERT_EQ(one.summary.iterations.size(), many.summary.iterations.size());
    for (std::size_t k = 0; k < one.summary.iterations.size(); ++k) {
      expect_same(one.summary.iterations[k], many.summary.iterations[k]);
    }
  }
}

// Loops over unknowns have grains of up to 16384: twice that and more, for those too.
TEST(DeterminismOfVectors, SameBitsForOneTwoAndThreeThreads) {
  const Problem problem = test::small_problem({.seed = 32, .cameras = 6, .points = 14000});
  for (const Options& options :
       {Options{.method = Method::dinm, .elimination = Elimination::cameras, .max_iterations = 2},
        Options{.method = Method::inm, .elimination = Elimination::none, .max_iterations = 2}}) {
    Options with = options;
    with.max_inner_iterations = 20;
    std::vector<double> points;
    for (const int threads : {1, 2, 3}) {
      with.threads = threads;
      Problem solved = problem;
      const Summary summary = solve(solved, with);
      EXPECT_GT(summary.inner_iterations, 2);
      if (threads == 1) points = solved.points;
      EXPECT_EQ(points, solved.points) << threads;
    }
  }
}

TEST_P(Determinism, SameBitsWhenRepeated) {
  const Solved first = solve_with(2, std::get<0>(GetParam()));
  const Solved second = solve_with(2, std::get<0>(GetParam()));
  EXPECT_EQ(first.problem.cameras, second.problem.cameras);
  EXPECT_EQ(first.problem.points, second.problem.points);
}

INSTANTIATE_TEST_SUITE_P(Variants, Determinism, ::testing::ValuesIn(variants()),
                         [](const auto& test) { return std::get<1>(test.param); });

}  // namespace
}  // namespace raybundle
