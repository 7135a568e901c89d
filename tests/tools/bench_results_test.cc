// What counts as the best cost of a problem, and how soon a run came near it.

#include <raybundle/tools/bench_results.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/tools/bench_report.h>

namespace raybundle::tools {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

BenchPlan plan_of(std::size_t problems) {
  BenchPlan plan;
  for (std::size_t p = 0; p < problems; ++p) {
    BenchProblem problem;
    problem.name = "p" + std::to_string(p);
    problem.best = infinity;
    plan.problems.push_back(problem);
  }
  return plan;
}

RunResult run_of(std::size_t problem, const std::vector<double>& costs, bool robust = false) {
  RunResult run;
  run.problem = problem;
  run.robust = robust;
  for (std::size_t k = 0; k < costs.size(); ++k) {
    run.trace.push_back({static_cast<int>(k), static_cast<double>(k), costs[k], NAN});
  }
  return run;
}

TEST(BenchResults, TheBestIsTheLeastCostOfAnyRun) {
  BenchResults results;
  results.runs = {run_of(0, {1000, 500, 100}), run_of(0, {1000, 80, 60, 50}), run_of(1, {10, 1})};
  complete(plan_of(2), results);
  EXPECT_EQ(results.start, (std::vector<double>{1000, 10}));
  EXPECT_EQ(results.best, (std::vector<double>{50, 1}));
  // Targets 50 + tau 950: 145, 59.5, 50.95, 50.0095.
  EXPECT_EQ(results.runs[0].seconds_to, (std::array<double, 4>{2, infinity, infinity, infinity}));
  EXPECT_EQ(results.runs[1].seconds_to, (std::array<double, 4>{1, 3, 3, 3}));
}

// A loss costs less than the squares: its runs would set a target that nobody else can reach.
TEST(BenchResults, RunsWithALossDoNotCountBesidePlainOnes) {
  BenchResults results;
  results.runs = {run_of(0, {1000, 100}), run_of(0, {40, 7, 3}, true), run_of(1, {40, 3}, true)};
  complete(plan_of(2), results);
  EXPECT_EQ(results.start[0], 1000);
  EXPECT_EQ(results.best[0], 100);
  EXPECT_EQ(results.runs[0].seconds_to, (std::array<double, 4>{1, 1, 1, 1}));
  for (const double seconds : results.runs[1].seconds_to) EXPECT_EQ(seconds, infinity);
  EXPECT_EQ(results.best[1], 3) << "alone they are compared with one another";
  EXPECT_EQ(results.runs[2].seconds_to, (std::array<double, 4>{1, 1, 1, 1}));
}

TEST(BenchResults, ACostOfAnotherKindIsNotSetAgainstTheBest) {
  BenchPlan plan = plan_of(1);
  plan.variants = {{"plain", BenchSolver::raybundle, {}}, {"robust", BenchSolver::raybundle, {}}};
  BenchResults results;
  results.runs = {run_of(0, {1000, 100}), run_of(0, {40, 50}, true)};
  results.runs[1].variant = 1;
  for (RunResult& run : results.runs) {
    run.status = RunStatus::ok;
    run.final_cost = run.trace.back().cost;
  }
  complete(plan, results);
  const std::string text = summary_markdown(plan, results, {});
  EXPECT_NE(text.find("| plain | ok | 100 | 1.000000 |"), std::string::npos) << text;
  EXPECT_NE(text.find("| robust | ok | 50 | - |"), std::string::npos) << text;
  EXPECT_NE(text.find("Medians of 3 runs; 1 thread;"), std::string::npos) << text;
}

// Five problems: one that both solve, one that one solves and the other has not run, one that
// nobody solves, one that was only refused, one that nobody has run.
TEST(BenchResults, SharesAreOfTheProblemsThatWereRun) {
  BenchPlan plan = plan_of(5);
  plan.variants = {{"a", BenchSolver::raybundle, {}}, {"b", BenchSolver::raybundle, {}}};
  BenchResults results;
  const auto add = [&](std::size_t problem, std::size_t variant, RunStatus status) {
    RunResult run = run_of(problem, {});
    if (status == RunStatus::ok) run = run_of(problem, {1000, 100});
    run.variant = variant;
    run.status = status;
    results.runs.push_back(run);
  };
  add(0, 0, RunStatus::ok);
  add(0, 1, RunStatus::ok);
  add(1, 0, RunStatus::ok);
  add(2, 0, RunStatus::crashed);
  add(2, 1, RunStatus::no_memory);
  add(3, 0, RunStatus::refused);
  add(3, 1, RunStatus::error);
  complete(plan, results);
  const std::vector<MedianResult> all = medians(plan, results);
  EXPECT_EQ(problems_run(plan, all), (std::vector<bool>{true, true, true, false, false}));
  const std::vector<Profile> profile = profiles(plan, all, 0);
  EXPECT_DOUBLE_EQ(share_at(profile[0], infinity), 2.0 / 3);
  EXPECT_DOUBLE_EQ(share_at(profile[1], infinity), 1.0 / 3);
  const std::string text = summary_markdown(plan, results, {});
  for (const std::string part : {"3 of 5 problems were run", "1 pair of variant and problem",
                                 "### p3\n\nNo run has a cost.", "### p4\n\nNot run.\n"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  }
  results.runs.clear();
  complete(plan, results);
  EXPECT_EQ(share_at(profiles(plan, medians(plan, results), 0)[1], infinity), 0);
}

TEST(BenchResults, ACostKnownBeforehandIsTheTargetWhenItIsLess) {
  BenchResults results;
  results.runs = {run_of(0, {1000, 100})};
  BenchPlan plan = plan_of(1);
  plan.problems[0].best = 20;
  complete(plan, results);
  EXPECT_EQ(results.best[0], 20);
  EXPECT_EQ(results.runs[0].seconds_to, (std::array<double, 4>{1, infinity, infinity, infinity}));
}

}  // namespace
}  // namespace raybundle::tools
