// What method auto chooses, and that the choice changes nothing but the time.

#include <raybundle/solver/solve.h>

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/linalg/reduced_pattern.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/solver/linear_work.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

Problem few_cameras() { return test::small_problem({.seed = 3, .cameras = 6, .points = 40}); }

// Long, and every camera sees its neighbours only.
Problem street(std::int64_t cameras, std::int64_t points) {
  return scenes::street({.seed = 4, .cameras = cameras, .points = points});
}

// What was taken is the least of all, bounds included, but for what an exact step is worth.
void expect_least(const Summary& summary) {
  const LinearChoice& choice = summary.linear_choice;
  ASSERT_EQ(choice.candidates.size(), 4U);
  EXPECT_GT(choice.expected.count, 0);
  for (const LinearCandidate& taken : choice.candidates) {
    if (taken.linear != summary.options.linear) continue;
    EXPECT_FALSE(taken.lower_bound);
    for (const LinearCandidate& other : choice.candidates) {
      EXPECT_LE(LinearForecast::weighed(taken, choice.expected),
                LinearForecast::weighed(other, choice.expected))
          << name(other.linear);
    }
  }
}

TEST(Automatic, FactorisesWhereThatIsLittle) {
  Problem problem = few_cameras(), again = few_cameras();
  const Summary chosen = solve(problem, {});
  const Summary forced =
      solve(again, {.method = Method::lm_cholesky, .damping_matrix = DiagonalMatrix::held_h});
  EXPECT_EQ(chosen.options.linear, Linear::dense_cholesky);
  expect_least(chosen);
  EXPECT_TRUE(forced.linear_choice.candidates.empty()) << "nothing was left to choose";
  EXPECT_EQ(chosen.inner_iterations, 0);
  EXPECT_EQ(chosen.final_cost, forced.final_cost);
  EXPECT_EQ(problem.points, again.points);
}

TEST(Automatic, IteratesWhereManyCamerasSeeLittle) {
  const Problem start =
      test::small_problem({.seed = 5, .cameras = 300, .points = 600, .observations_per_point = 3});
  Problem problem = start, again = start;
  const Summary chosen = solve(problem, {.max_iterations = 2});
  const Summary forced =
      solve(again,
            {.method = Method::tnm, .damping_matrix = DiagonalMatrix::held_h, .max_iterations = 2});
  EXPECT_EQ(chosen.options.linear, Linear::implicit_pcg);
  expect_least(chosen);
  EXPECT_GT(chosen.inner_iterations, 0);
  EXPECT_EQ(chosen.final_cost, forced.final_cost);
}

TEST(Automatic, GoesOverToFactorisingWhenTheInnerIterationsAreMany) {
  Problem problem = street(60, 3000);
  const Summary summary = solve(problem, {});
  EXPECT_EQ(outcome(summary.termination), Outcome::converged) << summary.message;
  ASSERT_GT(summary.iterations.size(), 3U);
  EXPECT_GT(summary.iterations[1].inner_iterations, 0);
  EXPECT_EQ(summary.iterations.back().inner_iterations, 0);
  EXPECT_EQ(summary.options.linear, Linear::dense_cholesky);
  EXPECT_NE(summary.linear_solver.find(", then "), std::string::npos) << summary.linear_solver;
  Problem again = street(60, 3000);
  const double expected = solve(again, {.method = Method::lm_cholesky}).final_cost;
  EXPECT_NEAR(summary.final_cost, expected, 1e-5 * expected);
}

// Ten leaves, each with the same hubs.
linalg::BlockLayout same_observers(int observers) {
  std::vector<std::int32_t> leaf, hub;
  for (std::int32_t l = 0; l < 10; ++l) {
    for (std::int32_t h = 0; h < observers; ++h) leaf.push_back(l), hub.push_back(h);
  }
  return linalg::make_layout({2, 9, 3}, 20, 10, leaf, hub);
}

TEST(Automatic, TakesTwoLevelsWhereFactorisingIsMoreWork) {
  Problem problem = street(150, 2250);
  const Summary summary = solve(problem, {});
  EXPECT_EQ(outcome(summary.termination), Outcome::converged) << summary.message;
  EXPECT_EQ(summary.options.linear, Linear::implicit_pcg);
  EXPECT_NE(summary.linear_solver.find("clusters"), std::string::npos) << summary.linear_solver;
}

TEST(InnerIterations, AreThoseOfTwoLevelsOnlyWhereTheseWillBe) {
  StepReport report = {.inner_iterations = 200};
  EXPECT_EQ(expected_after(report).count, 200);
  EXPECT_FALSE(expected_after(report).two_level);
  report.two_level_next = true;
  EXPECT_LT(expected_after(report).count, 200);
  EXPECT_TRUE(expected_after(report).two_level);
  report.two_level = true;
  EXPECT_EQ(expected_after(report).count, 200);
  EXPECT_TRUE(expected_after(report).two_level);
}

TEST(LinearWork, GrowsWithRowsAndWithPairs) {
  const LinearWork two = linear_work(same_observers(2)), ten = linear_work(same_observers(10));
  EXPECT_DOUBLE_EQ(ten.product, 5 * two.product);
  EXPECT_DOUBLE_EQ(ten.elimination, 5 * two.elimination);
  EXPECT_DOUBLE_EQ(ten.preconditioner, 5 * two.preconditioner);
  EXPECT_DOUBLE_EQ(ten.assembly, 55.0 / 3 * two.assembly);
  EXPECT_DOUBLE_EQ(ten.coarse, 5 * two.coarse);
}

// A sample raises the bounds, and what is known then does not fall below them.
TEST(LinearForecast, BoundsOfASampleLieBetween) {
  for (const std::int64_t cameras : {40, 400}) {
    const Problem problem = street(cameras, 20 * cameras);
    linalg::ThreadPool pool(2), one(1);
    const linalg::BlockLayout layout =
        linalg::make_layout({2, 9, 3}, problem.camera_count(), problem.point_count(),
                            problem.observation_point, problem.observation_camera);
    LinearForecast forecast(layout, 1e17);
    const std::vector<LinearCandidate> before = forecast.candidates();
    const double sampled = linalg::sampled_reduced_blocks(layout, linalg::Side::leaves, pool);
    EXPECT_EQ(sampled, linalg::sampled_reduced_blocks(layout, linalg::Side::leaves, one));
    const auto counted =
        static_cast<double>(linalg::count_reduced_blocks(layout, linalg::Side::leaves, pool));
    EXPECT_NEAR(sampled, counted, 0.3 * counted);
    forecast.expect(sampled);
    const std::vector<LinearCandidate> bounds = forecast.candidates();
    forecast.add(linalg::reduced_pattern(layout, linalg::Side::leaves, pool));
    for (std::size_t k = 0; k < bounds.size(); ++k) {
      EXPECT_EQ(bounds[k].lower_bound, before[k].lower_bound);
      for (const int inner : {0, 1, 100}) {
        EXPECT_GE(bounds[k].work_with({inner}), before[k].work_with({inner}));
        EXPECT_GE(forecast.candidates()[k].work_with({inner}), bounds[k].work_with({inner}));
      }
    }
  }
}

TEST(LinearForecast, BoundsHoldAndWhatDoesNotFitIsLeft) {
  const linalg::BlockLayout layout = same_observers(10);
  linalg::ThreadPool pool(1);
  LinearForecast forecast(layout, 1e17);
  const std::vector<LinearCandidate> before = forecast.candidates();
  linalg::CholeskyPlan plan = linalg::plan_cholesky(
      linalg::reduced_pattern(layout, linalg::Side::leaves, pool), 1, linalg::CholeskyKind::sparse);
  forecast.add(plan.pattern);
  const LinearCandidate sparse = forecast.candidates()[1];
  EXPECT_TRUE(sparse.lower_bound);
  EXPECT_FALSE(forecast.candidates()[2].lower_bound);
  forecast.add(plan);
  EXPECT_LE(sparse.work, forecast.candidates()[1].work);
  EXPECT_LE(sparse.memory, forecast.candidates()[1].memory);
  for (std::size_t k = 0; k < before.size(); ++k) {
    const LinearCandidate& after = forecast.candidates()[k];
    EXPECT_EQ(before[k].lower_bound, after.linear != Linear::implicit_pcg);
    EXPECT_FALSE(after.lower_bound);
    for (const int inner : {0, 1, 100}) {
      EXPECT_GE(after.work_with({inner}), before[k].work_with({inner}));
    }
  }
  EXPECT_FALSE(iterates(forecast.best({1000000}).linear)) << "its work does not grow";
  plan.sparse_memory = 1e18;
  forecast.add(plan);
  EXPECT_NE(forecast.best({1000000}).linear, Linear::sparse_cholesky);
  EXPECT_FALSE(forecast.candidates()[1].fits);
}

}  // namespace
}  // namespace raybundle
