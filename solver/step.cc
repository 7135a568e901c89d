#include <raybundle/solver/step.h>

#include <raybundle/solver/methods.h>

#include <cmath>

namespace raybundle {

std::unique_ptr<StepSolver> make_step_solver(const Options& options,
                                             const linalg::BlockLayout& layout,
                                             linalg::ThreadPool& pool) {
  return traits(options.method).inner == InnerSolve::pcg
             ? make_pcg_step(options, layout, pool)
             : make_cholesky_step(options, layout, pool);
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

void inverse_scaling(DiagonalMatrix scaling, const linalg::NormalEquations& normal,
                     std::vector<double>& inverse) {
  inverse.clear();
  if (scaling == DiagonalMatrix::identity) return;
  inverse.resize(normal.gradient.size());
  normal.diagonal(min_diagonal, max_diagonal, inverse.data());
  for (double& d : inverse) d = 1 / std::sqrt(d);
}

}  // namespace raybundle
