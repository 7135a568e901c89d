#include <raybundle/solver/solve.h>

#include <raybundle/models/objective.h>
#include <raybundle/solver/loss_schedule.h>
#include <raybundle/solver/methods.h>
#include <raybundle/solver/step.h>
#include <raybundle/solver/trust_region.h>
#include <raybundle/solver/working_memory.h>

#include <algorithm>
#include <string>

namespace raybundle {
namespace {

constexpr double process_growth = 2e6;  // stacks of threads, records, what the log is made of

// Refuses what does not fit beside what the process has already; returns what it leaves.
double require_working_memory(const Problem& problem, const Options& options) {
  const std::string what = "solving " + std::to_string(problem.observation_count()) +
                           " observations by " + name(options.method);
  const double needed = working_memory(problem, options) + process_growth;
  linalg::require_memory(needed, what);
  const double resident = linalg::resident_memory();
  const double left = options.memory_limit - resident - needed;
  if (left < 0) {
    throw MemoryRefusal(what + " needs " + linalg::memory_text(needed) + " beside " +
                        linalg::memory_text(resident) + " in use, and the limit is " +
                        linalg::memory_text(options.memory_limit));
  }
  return std::min(left, linalg::available_memory() - needed);
}

}  // namespace

Summary solve(Problem& problem, const Options& options, const Observer& observer) {
  const auto start = TrustRegion::Clock::now();
  Options effective = resolve(options);
  validate_sizes(problem);  // what is predicted counts on them
  const bool graduated = traits(effective.method).graduated && effective.loss != Loss::none;
  if (graduated && !effective.loss_start_scale) {
    validate(problem);
    effective.loss_start_scale = wide_start_scale(problem, *effective.loss_scale);
  }
  linalg::ThreadPool pool(options.threads > 0 ? options.threads : linalg::available_threads());
  effective.threads = pool.threads();

  const double left_for_matrix = require_working_memory(problem, effective);
  Objective objective(problem, formulation(effective), pool, robust_loss(effective));
  Options for_steps = effective;
  for_steps.memory_limit = left_for_matrix;
  const auto steps = make_step_solver(for_steps, objective.layout(), pool);
  effective.linear = steps->linear();

  State state = effective.point_start == PointStart::rays ? objective.state_from_rays(problem)
                                                          : objective.state_of(problem);
  TrustRegion engine(objective, *steps, pool, effective, observer, start);
  Summary summary = engine.run(state);
  summary.threads = pool.threads();
  summary.options.linear = steps->linear();  // auto may have changed it
  summary.linear_solver = steps->description();
  summary.linear_choice = steps->choice();
  objective.write(std::move(state), problem);
  return summary;
}

}  // namespace raybundle
