#include <raybundle/solver/step.h>

#include <raybundle/solver/methods.h>

namespace raybundle {

std::unique_ptr<StepSolver> make_step_solver(const Options& options,
                                             const linalg::BlockLayout& layout,
                                             linalg::ThreadPool& pool) {
  const MethodTraits& method = traits(options.method);
  if (method.inner == InnerSolve::cholesky) return make_cholesky_step(options, layout, pool);
  if (method.inner == InnerSolve::automatic) return make_automatic_step(options, layout, pool);
  if (method.inner == InnerSolve::dogleg) return make_dogleg_step(options, layout, pool);
  if (method.adaptive) return make_adaptive_step(options, layout, pool);
  return make_pcg_step(options, *options.elimination, layout, pool);
}

double step_memory(const Options& options, const linalg::LayoutSize& n) {
  const MethodTraits& method = traits(options.method);
  if (method.inner == InnerSolve::cholesky) return cholesky_step_memory(options, n);
  if (method.inner == InnerSolve::dogleg) return dogleg_step_memory(options, n);
  if (method.adaptive) return adaptive_step_memory(options, n);
  return pcg_step_memory(options, *options.elimination, n);  // auto: with a matrix it takes less
}

bool has_coarse_space(const Options& options) {
  return options.preconditioner == Preconditioner::two_level ||
         options.preconditioner == Preconditioner::adaptive;
}

std::optional<linalg::Side> eliminated_side(Elimination elimination) {
  switch (elimination) {
    case Elimination::points:
      return linalg::Side::leaves;
    case Elimination::cameras:
      return linalg::Side::hubs;
    case Elimination::none:
      break;
  }
  return std::nullopt;
}

}  // namespace raybundle
