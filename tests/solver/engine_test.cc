// What a solve reports and leaves behind: records, summaries, observers.

#include <raybundle/solver/solve.h>

#include <cstdint>
#include <new>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <raybundle/models/error.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/support/dense_objective.h>
#include <raybundle/tests/support/numeric_jacobian.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

using Eigen::VectorXd;
using test::DenseObjective;
using test::small_problem;

constexpr Method methods[] = {Method::lm_cholesky, Method::tnm};

// A start that is bad enough for some steps to be rejected.
Problem hard_problem(std::uint64_t seed) {
  return small_problem({.seed = seed, .points = 30, .points_seen_once = 2, .parameter_noise = 0.3});
}

std::vector<Problem> problems() {
  std::vector<Problem> list = {small_problem({.seed = 1}),
                               small_problem({.seed = 2,
                                              .cameras = 6,
                                              .points = 40,
                                              .duplicate_observations = 5,
                                              .unobserved_cameras = 1,
                                              .unobserved_points = 2,
                                              .points_seen_once = 2,
                                              .far_points = 2,
                                              .shuffled = true})};
  for (const std::uint64_t seed : {11, 12, 13, 14}) list.push_back(hard_problem(seed));
  return list;
}

TEST(Engine, NeverEndsAboveItsStartNorRises) {
  int rejected = 0;
  for (const Method method : methods) {
    for (Problem& problem : problems()) {
      const double start = reprojection_statistics(problem).cost;
      const Summary summary = solve(problem, {.method = method});
      EXPECT_NEAR(summary.initial_cost, start, 1e-12 * start);
      double previous = summary.iterations.front().cost;
      EXPECT_EQ(previous, summary.initial_cost);
      for (const IterationRecord& record : summary.iterations) {
        EXPECT_LE(record.cost, previous) << "iteration " << record.iteration;
        previous = record.cost;
        rejected += record.accepted ? 0 : 1;
      }
      EXPECT_EQ(summary.final_cost, previous);
      const double end = reprojection_statistics(problem).cost;
      EXPECT_NEAR(summary.final_cost, end, 1e-12 * end) << "the state is that of the cost";
    }
  }
  EXPECT_GT(rejected, 0) << "the problems should be hard enough to say something";
}

// The verdict is made on the candidate's cost: the kept cost is that very number, or an accepted
// step could raise the reported cost by a rounding error.
TEST(Engine, AnAcceptedCostIsTheCandidatesToTheBit) {
  for (Problem& problem : problems()) {
    const Summary summary = solve(problem);
    for (const IterationRecord& record : summary.iterations) {
      if (record.iteration == 0 || !record.accepted) continue;
      EXPECT_EQ(record.cost, record.candidate_cost) << "iteration " << record.iteration;
    }
    DenseObjective end(problem, formulation(summary.options));
    EXPECT_EQ(summary.final_cost, end.objective().cost(end.state()));
  }
}

// From the minimum nothing can be gained; rounding must not be taken for a gain.
TEST(Engine, SolvingAgainDoesNotRaiseTheCost) {
  for (Problem& problem : problems()) {
    const Options exact = {.max_iterations = 100,
                           .function_tolerance = 0,
                           .gradient_tolerance = 0,
                           .parameter_tolerance = 0};
    double previous = solve(problem, exact).final_cost;
    for (int k = 0; k < 3; ++k) {
      const Summary summary = solve(problem, exact);
      EXPECT_LE(summary.initial_cost, previous) << "the state carries its cost";
      EXPECT_LE(summary.final_cost, summary.initial_cost);
      previous = summary.final_cost;
    }
  }
}

TEST(Engine, RecordsAreConsistent) {
  for (const Method method : methods) {
    for (Problem& problem : problems()) {
      const Summary summary = solve(problem, {.method = method});
      int accepted = 0;
      std::int64_t inner = 0;
      double seconds = 0;
      for (std::size_t k = 0; k < summary.iterations.size(); ++k) {
        const IterationRecord& record = summary.iterations[k];
        EXPECT_EQ(record.iteration, static_cast<int>(k));
        EXPECT_EQ(record.radius, 0) << "these methods have none";
        EXPECT_GE(record.seconds, seconds);
        seconds = record.seconds;
        inner += record.inner_iterations;
        if (k == 0) {
          EXPECT_TRUE(record.accepted);
          continue;
        }
        EXPECT_EQ(record.eliminated, Elimination::points);
        const IterationRecord& before = summary.iterations[k - 1];
        accepted += record.accepted ? 1 : 0;
        EXPECT_EQ(record.accepted, record.rho > 0);
        if (record.accepted) {
          EXPECT_GT(record.step_norm, 0);
          EXPECT_GT(record.relative_step, 0);
          EXPECT_GT(record.predicted_decrease, 0);
        } else {
          EXPECT_EQ(record.cost, before.cost);
          EXPECT_EQ(record.gradient_norm, before.gradient_norm);
          EXPECT_EQ(record.gradient_max, before.gradient_max);
        }
        if (k > 1) {
          EXPECT_EQ(record.damping > before.damping, !(before.rho >= 0.5)) << "[Qu18, Alg. 6]";
        }
        EXPECT_LE(record.gradient_max, record.gradient_norm);
      }
      EXPECT_EQ(summary.accepted, accepted);
      EXPECT_EQ(summary.inner_iterations, inner);
      EXPECT_EQ(summary.linear_solves, static_cast<int>(summary.iterations.size()) - 1);
      EXPECT_EQ(summary.gradient_norm, summary.iterations.back().gradient_norm);
      EXPECT_EQ(inner > 0, method == Method::tnm);
      EXPECT_FALSE(summary.message.empty());
      EXPECT_FALSE(summary.linear_solver.empty());
      EXPECT_TRUE(summary.options.linear.has_value());
      EXPECT_GE(summary.seconds.total, summary.seconds.linear);
    }
  }
}

// [Qu18, Eq. 3.42] for the global update, whose unknowns are the numbers of the file.
TEST(Engine, GradientNormIsThatOfDifferences) {
  const Problem problem = small_problem({.seed = 3, .points = 12, .points_seen_once = 1});
  std::vector<double> norms, largest;
  for (const int iterations : {0, 1, 2}) {
    Problem moved = problem;
    const Summary summary =
        solve(moved, {.pose_update = PoseUpdate::global, .max_iterations = iterations});
    DenseObjective at(moved, PoseUpdate::global, Lens::free);
    const VectorXd g =
        test::numeric_gradient([&](const VectorXd& x) { return at.cost_after(x); },
                               VectorXd::Zero(at.objective().layout().unknowns()), 0.1);
    EXPECT_NEAR(summary.gradient_norm, g.norm(), 1e-6 * (g.norm() + 1e-3 * at.cost()));
    EXPECT_NEAR(summary.iterations.back().gradient_max, g.cwiseAbs().maxCoeff(),
                1e-6 * (g.norm() + 1e-3 * at.cost()));
  }
}

TEST(Engine, FixedParametersKeepTheirBitsThroughASolve) {
  for (const PoseUpdate update : {PoseUpdate::global, PoseUpdate::local, PoseUpdate::se3}) {
    for (const Method method : methods) {
      for (const Elimination elimination :
           {Elimination::none, Elimination::points, Elimination::cameras}) {
        Problem problem = small_problem(
            {.seed = 4, .cameras = 5, .unobserved_cameras = 1, .unobserved_points = 1});
        problem.fixed_camera_parameters = {0b000'111'111, 0, 0b111'000'000, 0b010'000'000, 0};
        problem.fixed_points.assign(20, 0);
        problem.fixed_points[3] = 1;
        const Problem before = problem;
        const Summary summary =
            solve(problem, {.method = method, .elimination = elimination, .pose_update = update});
        EXPECT_LT(summary.final_cost, 0.5 * summary.initial_cost);
        for (std::size_t c = 0; c < 5; ++c) {
          for (std::size_t k = 0; k < 9; ++k) {
            const bool fixed = (before.fixed_camera_parameters[c] >> k & 1) != 0 || c == 4;
            EXPECT_EQ(problem.cameras[9 * c + k] == before.cameras[9 * c + k], fixed)
                << "camera " << c << ", parameter " << k;
          }
        }
        for (std::size_t i = 0; i < 20; ++i) {
          EXPECT_EQ(problem.points[3 * i] == before.points[3 * i], i == 3 || i == 19) << i;
        }
      }
    }
  }
}

TEST(Observer, SeesEveryRecordOnce) {
  for (const Method method : methods) {
    Problem problem = hard_problem(11);
    std::vector<IterationRecord> seen;
    const Summary summary = solve(problem, {.method = method}, [&](const IterationRecord& record) {
      seen.push_back(record);
      return Control::proceed;
    });
    ASSERT_EQ(seen.size(), summary.iterations.size());
    for (std::size_t k = 0; k < seen.size(); ++k) {
      EXPECT_EQ(seen[k].iteration, summary.iterations[k].iteration);
      EXPECT_EQ(seen[k].cost, summary.iterations[k].cost);
      EXPECT_EQ(seen[k].seconds, summary.iterations[k].seconds);
    }
  }
}

TEST(Observer, SeesABadStartToo) {
  Problem problem = small_problem({.seed = 5});
  problem.cameras[6] = 1e200;
  int seen = 0;
  const Summary summary = solve(problem, {}, [&](const IterationRecord&) {
    ++seen;
    return Control::proceed;
  });
  EXPECT_EQ(summary.termination, Termination::bad_start);
  EXPECT_EQ(static_cast<std::size_t>(seen), summary.iterations.size());
}

TEST(Observer, StopsWithTheBestState) {
  for (const int last : {0, 1, 3}) {
    Problem problem = hard_problem(12), reference = problem;
    const Summary summary = solve(problem, {}, [&](const IterationRecord& record) {
      return record.iteration == last ? Control::stop : Control::proceed;
    });
    EXPECT_EQ(summary.termination, Termination::stopped);
    EXPECT_EQ(outcome(summary.termination), Outcome::interrupted);
    ASSERT_EQ(summary.iterations.size(), static_cast<std::size_t>(last) + 1);
    const Summary limited = solve(reference, {.max_iterations = last});
    EXPECT_EQ(limited.termination, Termination::max_iterations);
    EXPECT_EQ(problem.cameras, reference.cameras) << "a limit and a stop leave the same state";
    EXPECT_EQ(summary.final_cost, limited.final_cost);
  }
}

TEST(Observer, ExceptionsPassThroughAndLeaveTheProblemAlone) {
  Problem problem = hard_problem(13);
  const Problem before = problem;
  EXPECT_THROW((void)solve(problem, {},
                           [](const IterationRecord& record) {
                             if (record.iteration == 2) throw std::runtime_error("enough");
                             return Control::proceed;
                           }),
               std::runtime_error);
  EXPECT_EQ(problem.cameras, before.cameras);
  EXPECT_EQ(problem.points, before.points);
}

TEST(Engine, RefusesInconsistentProblems) {
  Problem problem = small_problem();
  problem.observation_point[3] = 1000;
  EXPECT_THROW((void)solve(problem), InputError);
  problem = small_problem();
  problem.observation_point.pop_back();
  EXPECT_THROW((void)solve(problem), InputError);
  problem = small_problem();
  problem.observations.clear();
  EXPECT_THROW((void)solve(problem), InputError);
}

TEST(Engine, KeepsTheBestStateWhereMemoryEnds) {
  Problem problem = small_problem();
  const Problem start = problem;
  const Summary summary = solve(problem, {}, [](const IterationRecord& record) -> Control {
    if (record.iteration == 2) throw std::bad_alloc();
    return Control::proceed;
  });
  EXPECT_EQ(summary.termination, Termination::out_of_memory) << summary.message;
  EXPECT_EQ(outcome(summary.termination), Outcome::failed);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_NE(problem.points, start.points);
  const double cost = reprojection_statistics(problem).cost;
  EXPECT_NEAR(cost, summary.final_cost, 1e-12 * cost);
}

}  // namespace
}  // namespace raybundle
