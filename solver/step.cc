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
