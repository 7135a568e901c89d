#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <raybundle/tools/bench_plan.h>
#include <raybundle/tools/bench_profile.h>
#include <raybundle/tools/bench_stamp.h>

/// What the runs of a bench achieved, read from its folder.
namespace raybundle::tools {

/// The accuracies that profiles are made for. Starts cost a hundred times what solutions do, so
/// that 1e-3 is still some ten per cent above the best cost; 1e-5 is about a thousandth above.
inline constexpr std::array<double, 4> accuracies = {1e-1, 1e-2, 1e-3, 1e-5};

struct Iterate {
  int iteration;
  double seconds;
  double cost;           ///< of the state that is kept
  double gradient_norm;  ///< NaN when the log does not say
};

/// One run. What is not known is NaN, or -1 for whole numbers.
struct RunResult {
  std::size_t problem = 0;  ///< index in the plan
  std::size_t variant = 0;
  int run = 0;
  RunStatus status = RunStatus::error;
  std::string message;
  std::string termination;
  bool robust = false;    ///< minimised a robust loss
  bool compared = false;  ///< its cost is of the kind that start and best are of; complete() says
  std::vector<Iterate> trace;
  double initial_cost = NAN;
  double final_cost = NAN;
  double gradient_norm = NAN;
  int iterations = -1;
  int inner_iterations = -1;
  double seconds = NAN;                                   ///< of the solve
  std::array<double, accuracies.size()> seconds_to = {};  ///< infinite: never
  std::int64_t peak_bytes = -1;
  double camera_rmse = NAN;
  double point_rmse = NAN;
};

/// The median over the runs of one variant on one problem.
struct MedianResult {
  std::size_t problem, variant;
  std::string status;  ///< "ok", or "2 ok, 1 crashed"
  bool carried_out;    ///< at least one run was: not refused, and not ended by the system
  bool compared;       ///< so is the cost of each of its runs that has one
  double final_cost, gradient_norm, iterations, inner_iterations, seconds;
  std::array<double, accuracies.size()> seconds_to;
  double peak_bytes, camera_rmse, point_rmse;
  const RunResult* middle;  ///< the run of the median time, for curves; null: none has a trace
};

struct BenchResults {
  std::vector<RunResult> runs;
  std::vector<double> start;  ///< of each problem: the cost at the start; NaN: no run
  std::vector<double> best;   ///< the least cost of any run that counts, or known beforehand
};

/// Reads one run; status `error` and an empty trace for one that is not there.
RunResult read_run(const BenchPlan& plan, const BenchProblem& problem, const BenchVariant& variant,
                   int run);

/// Fills in start, best and the times to each accuracy. Costs of a loss do not compare with those
/// of plain squares: where both are there, runs with a loss count as never there.
void complete(const BenchPlan& plan, BenchResults& results);

/// All runs that are there and were made with the plan's options, completed. What is left of an
/// earlier plan is not of this one, even where the variant has the same name.
BenchResults read_results(const BenchPlan& plan);

/// One for each pair that has runs, problem by problem.
std::vector<MedianResult> medians(const BenchPlan& plan, const BenchResults& results);

/// Of each problem, whether anybody's run on it was carried out.
std::vector<bool> problems_run(const BenchPlan& plan, const std::vector<MedianResult>& medians);

/// The profile of every variant at accuracies[which], over the problems that were run.
std::vector<Profile> profiles(const BenchPlan& plan, const std::vector<MedianResult>& medians,
                              std::size_t which);

}  // namespace raybundle::tools
