// Points that stay: cameras move alone, and anchored points go with them.

#include <raybundle/solver/solve.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/objective.h>
#include <raybundle/models/scenes/street.h>

namespace raybundle {
namespace {

Problem street() { return scenes::street({.seed = 2, .cameras = 12, .points = 300}); }

TEST(PointsThatStay, AreTheSamePointsAndWhatFixedOnesLeadTo) {
  for (const Method method : {Method::lm_cholesky, Method::tnm, Method::automatic}) {
    Problem stay = street(), fixed = street();
    const std::vector<double> points = stay.points;
    Options options = {.method = method, .max_iterations = 100, .function_tolerance = 1e-12};
    fixed.fixed_points.assign(static_cast<std::size_t>(fixed.point_count()), 1);
    const Summary of_fixed = solve(fixed, options);
    options.point_steps = PointSteps::none;
    const Summary of_staying = solve(stay, options);
    EXPECT_EQ(stay.points, points);
    EXPECT_NEAR(of_staying.final_cost, of_fixed.final_cost, 1e-6 * of_fixed.final_cost)
        << name(method);
    EXPECT_LT(of_staying.final_cost, 0.9 * of_staying.initial_cost);
    EXPECT_TRUE(of_staying.usable());
  }
}

// The cost of moved positions, points keeping direction and parallax.
class Positions {
 public:
  explicit Positions(const Problem& problem)
      : objective_(
            problem,
            {.lens = Lens::fixed, .points = PointModel::pmba, .objective = ObjectiveKind::ray},
            pool_),
        state_(objective_.state_of(problem)) {}

  double largest_slope() {
    double largest = 0;
    for (std::size_t i = 0; i < state_.cameras.size(); ++i) {
      if (i % 9 < 3 || i % 9 > 5) continue;
      constexpr double step = 1e-5;
      State moved = state_;
      moved.cameras[i] += step;
      const double more = objective_.cost(moved);
      moved.cameras[i] -= 2 * step;
      largest = std::max(largest, std::abs(more - objective_.cost(moved)) / (2 * step));
    }
    return largest;
  }

 private:
  linalg::ThreadPool pool_{1};
  Objective objective_;
  State state_;
};

TEST(PointsThatStay, RegisterPositionsWithTheirAnchors) {
  Problem problem = with_points_from_rays(street(), PointModel::pmba);
  problem.fixed_camera_parameters.assign(static_cast<std::size_t>(problem.camera_count()), 0b111);
  const double at_first = Positions(problem).largest_slope();
  const std::vector<double> before = problem.cameras;
  const Summary summary = solve(problem, {.method = Method::lm_cholesky,
                                          .points = PointModel::pmba,
                                          .point_steps = PointSteps::none,
                                          .objective = ObjectiveKind::ray,
                                          .max_iterations = 200,
                                          .function_tolerance = 1e-14});
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_LT(Positions(problem).largest_slope(), 1e-4 * at_first);
  for (std::size_t i = 0; i < before.size(); ++i) {
    const bool held = i % 9 < 3 || i % 9 > 5;
    EXPECT_TRUE(!held || problem.cameras[i] == before[i]) << i;
  }
}

void expect_refused(Options options, const std::string& complaint) {
  options.point_steps = PointSteps::none;
  try {
    static_cast<void>(resolve(options));
    ADD_FAILURE() << complaint;
  } catch (const OptionError& error) {
    EXPECT_NE(std::string(error.what()).find(complaint), std::string::npos) << error.what();
  }
}

TEST(PointsThatStay, NeedADampingAndToBeEliminated) {
  expect_refused({.method = Method::dogleg}, "no damping to hold points by");
  expect_refused({.method = Method::inm}, "no damping to hold points by");
  expect_refused({.method = Method::adinm}, "another method than adinm");
  expect_refused({.method = Method::tnm, .elimination = Elimination::cameras},
                 "--elimination points");
  expect_refused({.method = Method::tnm, .elimination = Elimination::none}, "--elimination points");
}

}  // namespace
}  // namespace raybundle
