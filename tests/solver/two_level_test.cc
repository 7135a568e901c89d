// Preconditioning by two levels: long chains of cameras take few inner iterations, and the minimum
// is that of other ways.

#include <raybundle/solver/solve.h>

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include <raybundle/linalg/coarse_space.h>
#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/sanitized.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/solver/step.h>
#include <raybundle/solver/working_memory.h>

namespace raybundle {
namespace {

Problem street(std::int64_t cameras) {
  return scenes::street({.seed = 4, .cameras = cameras, .points = 15 * cameras});
}

Summary solved(Problem problem, Options options) {
  options.max_iterations = std::min(options.max_iterations, 30);
  return solve(problem, options);
}

TEST(TwoLevel, LongChainsTakeFewerInnerIterations) {
  const Problem problem = street(150);
  const auto of = [&](Preconditioner preconditioner) {
    return solved(problem, {.method = Method::tnm, .preconditioner = preconditioner});
  };
  const Summary one = of(Preconditioner::block_diag_s), two = of(Preconditioner::two_level);
  EXPECT_LT(3 * two.inner_iterations, one.inner_iterations);
  EXPECT_LE(two.final_cost, one.final_cost * (1 + 1e-4));
  EXPECT_NE(two.linear_solver.find("clusters"), std::string::npos) << two.linear_solver;
}

TEST(TwoLevel, FindsTheMinimumWhateverIsDescribedOrHeld) {
  Problem held = street(40);
  held.fixed_camera_parameters.assign(40, 0);
  held.fixed_camera_parameters[0] = 0b111111;
  held.fixed_camera_parameters[20] = 0b111000000;
  held.fixed_points.assign(held.points.size() / 3, 0);
  held.fixed_points[5] = 1;
  const auto both = [](const Problem& problem, Options options) {
    options.function_tolerance = 1e-9;
    options.forcing = 0.01;
    options.max_iterations = 100;
    options.method = Method::tnm;
    Problem first = problem, second = problem;
    options.preconditioner = Preconditioner::two_level;
    const Summary two = solve(first, options);
    options.preconditioner = Preconditioner::block_diag_s;
    const Summary one = solve(second, options);
    EXPECT_NEAR(two.final_cost, one.final_cost, 1e-5 * one.final_cost);
    EXPECT_LE(two.inner_iterations, one.inner_iterations);
    for (std::size_t k = 0; k < 6 && !problem.fixed_camera_parameters.empty(); ++k) {
      EXPECT_EQ(first.cameras[k], problem.cameras[k]);
    }
  };
  for (const PoseUpdate update : {PoseUpdate::global, PoseUpdate::local, PoseUpdate::se3}) {
    both(held, {.pose_update = update});
    both(street(40), {.pose_update = update, .lens = Lens::fixed, .gauge = Gauge::fixed});
  }
  both(street(40), {.lens = Lens::fixed, .points = PointModel::pmba});
  both(street(40), {.lens = Lens::fixed, .objective = ObjectiveKind::ray});
}

TEST(TwoLevel, ServesARegionWithScaledUnknowns) {
  const Problem problem = street(100);
  const auto of = [&](Preconditioner preconditioner) {
    return solved(problem, {.method = Method::dinm, .preconditioner = preconditioner});
  };
  const Summary one = of(Preconditioner::block_diag_s), two = of(Preconditioner::two_level);
  EXPECT_LE(two.final_cost, one.final_cost * (1 + 1e-3));
  EXPECT_LT(two.inner_iterations, one.inner_iterations);
}

// What a coarse space may take is known once its clusters are.
TEST(TwoLevel, AreRefusedOrLeftWhereTheyWouldTakeTooMuch) {
  const Problem problem = street(600);
  linalg::ThreadPool pool(1);
  const Objective objective(problem, {}, pool);
  const double coarse = linalg::CoarseSpace::memory(objective.layout(), pool);
  Options options = resolve({.method = Method::tnm, .preconditioner = Preconditioner::two_level});
  options.memory_limit = 0.99 * coarse;
  EXPECT_THROW((void)make_step_solver(options, objective.layout(), pool), MemoryRefusal);
  options.memory_limit = coarse;
  EXPECT_NO_THROW((void)make_step_solver(options, objective.layout(), pool));

  if (linalg::sanitized) return;  // which keeps what is freed
  options = {.method = Method::tnm, .max_iterations = 6, .threads = 1};
  const double needed = linalg::resident_memory() + working_memory(problem, resolve(options));
  options.memory_limit = needed + 0.5 * coarse;
  const Summary without = solved(problem, options);
  EXPECT_EQ(without.linear_solver.find("clusters"), std::string::npos) << without.linear_solver;
  EXPECT_LT(without.final_cost, without.initial_cost);
  options.memory_limit = needed + 10 * coarse;
  const Summary with = solved(problem, options);
  EXPECT_NE(with.linear_solver.find("clusters"), std::string::npos) << with.linear_solver;
}

TEST(Adaptive, GoesOverToTwoLevelsWhereInnerIterationsAreMany) {
  const Problem problem = street(150);
  const Summary adaptive = solved(problem, {.method = Method::tnm});
  const Summary one =
      solved(problem, {.method = Method::tnm, .preconditioner = Preconditioner::block_diag_s});
  EXPECT_EQ(adaptive.options.preconditioner, Preconditioner::adaptive);
  EXPECT_NE(adaptive.linear_solver.find("clusters"), std::string::npos) << adaptive.linear_solver;
  EXPECT_LT(2 * adaptive.inner_iterations, one.inner_iterations);
  // Where they are few it is block-diag-s, to the last bit.
  const Summary easy = solved(street(10), {.method = Method::tnm, .max_inner_iterations = 20});
  const Summary same = solved(street(10), {.method = Method::tnm,
                                           .preconditioner = Preconditioner::block_diag_s,
                                           .max_inner_iterations = 20});
  EXPECT_EQ(easy.final_cost, same.final_cost);
  EXPECT_EQ(easy.inner_iterations, same.inner_iterations);
}

TEST(Adaptive, HasTheSameBitsForAnyNumberOfThreads) {
  Problem one = street(120), two = one;
  const Summary first = solve(one, {.method = Method::tnm, .max_iterations = 12, .threads = 1});
  const Summary second = solve(two, {.method = Method::tnm, .max_iterations = 12, .threads = 2});
  EXPECT_NE(first.linear_solver.find("clusters"), std::string::npos) << first.linear_solver;
  EXPECT_EQ(first.final_cost, second.final_cost);
  EXPECT_EQ(first.inner_iterations, second.inner_iterations);
  EXPECT_EQ(one.points, two.points);
  EXPECT_EQ(one.cameras, two.cameras);
}

}  // namespace
}  // namespace raybundle
