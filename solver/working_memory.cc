#include <raybundle/solver/working_memory.h>

#include <raybundle/models/objective.h>
#include <raybundle/solver/diagnosis.h>
#include <raybundle/solver/step.h>
#include <raybundle/solver/trust_region.h>

namespace raybundle {

double working_memory(const Problem& problem, const Options& options) {
  const Formulation form = formulation(options);
  const linalg::LayoutSize n = Objective::layout_size(problem, form);
  return Objective::memory(problem, form) + TrustRegion::memory(n, options) +
         step_memory(options, n) + (options.diagnose ? Diagnoser::memory(n) : 0);
}

double problem_memory(const Problem& problem) {
  return 8 * static_cast<double>(problem.cameras.size() + problem.points.size()) +
         24 * static_cast<double>(problem.observation_count());
}

}  // namespace raybundle
