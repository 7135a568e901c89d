// Methods and eliminations against one another where points are anchored: the same first step, and
// in the end the same minimum, whichever way points are described.

#include <raybundle/solver/solve.h>

#include <array>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/solver/methods.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

constexpr std::array anchored = {PointModel::idp, PointModel::pba, PointModel::pmba};
constexpr std::array eliminations = {Elimination::none, Elimination::points};

Problem problem_to_solve() {
  return test::small_problem({.seed = 23,
                              .cameras = 6,
                              .points = 40,
                              .observations_per_point = 4,
                              .duplicate_observations = 2,
                              .unobserved_cameras = 1,
                              .unobserved_points = 1,
                              .points_seen_once = 2});
}

Summary solved(Options options, Problem problem = problem_to_solve()) {
  options.lens = Lens::fixed;
  options.max_iterations = 300;
  options.function_tolerance = 1e-13;
  options.gradient_tolerance = 0;
  options.parameter_tolerance = 0;
  return solve(problem, options);
}

using Case = std::tuple<PointModel, ObjectiveKind>;

class AnchoredMinimum : public ::testing::TestWithParam<Case> {};

TEST_P(AnchoredMinimum, IsThatOfCoordinatesForEveryMethod) {
  const auto [points, objective] = GetParam();
  const double expected = solved({.objective = objective}).final_cost;
  for (int k = 0; k < enum_count<Method>; ++k) {
    const auto method = static_cast<Method>(k);
    if (traits(method).adaptive) continue;  // refused
    for (const Elimination elimination : eliminations) {
      const Summary summary = solved({.method = method,
                                      .elimination = elimination,
                                      .points = points,
                                      .objective = objective,
                                      .loss = Loss::none});
      EXPECT_NEAR(summary.final_cost, expected, 1e-6 * expected)
          << name(method) << ", eliminating " << name(elimination) << ": " << summary.message;
    }
  }
}

TEST_P(AnchoredMinimum, FirstStepIsTheSameOfEitherElimination) {
  const auto [points, objective] = GetParam();
  std::vector<double> costs;
  for (const Elimination elimination : eliminations) {
    for (const Linear linear : {Linear::dense_cholesky, Linear::sparse_cholesky}) {
      Problem problem = problem_to_solve();
      const Summary summary = solve(problem, {.elimination = elimination,
                                              .linear = linear,
                                              .lens = Lens::fixed,
                                              .points = points,
                                              .objective = objective,
                                              .max_iterations = 1,
                                              .initial_damping = 1e-2});
      ASSERT_EQ(summary.accepted, 1);
      costs.push_back(summary.final_cost);
    }
  }
  for (const double cost : costs) EXPECT_NEAR(cost, costs[0], 1e-10 * costs[0]);
}

// What stays fixed stays, and the solve with it ends where that of coordinates does.
TEST_P(AnchoredMinimum, WithFixedPartsIsThatOfCoordinates) {
  const auto [points, objective] = GetParam();
  Problem problem = problem_to_solve();
  problem.fixed_camera_parameters.assign(6, 0);
  problem.fixed_camera_parameters[0] = problem.fixed_camera_parameters[2] = 0b111'111;
  problem.fixed_points.assign(40, 0);
  for (std::size_t i = 0; i < 40; i += 7) problem.fixed_points[i] = 1;
  const double expected = solved({.objective = objective}, problem).final_cost;
  for (const Method method : {Method::lm_cholesky, Method::dinm, Method::dogleg}) {
    const Summary summary =
        solved({.method = method, .points = points, .objective = objective}, problem);
    EXPECT_NEAR(summary.final_cost, expected, 1e-6 * expected)
        << name(method) << ": " << summary.message;
  }
}

INSTANTIATE_TEST_SUITE_P(Models, AnchoredMinimum,
                         ::testing::Combine(::testing::ValuesIn(anchored),
                                            ::testing::Values(ObjectiveKind::pixel,
                                                              ObjectiveKind::ray)),
                         [](const auto& each) {
                           return std::string(name(std::get<0>(each.param))) +
                                  name(std::get<1>(each.param));
                         });

}  // namespace
}  // namespace raybundle
