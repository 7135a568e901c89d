#include <raybundle/linalg/cholesky.h>
#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/reduced_pattern.h>
#include <raybundle/solver/step.h>

#include <string>
#include <utility>

namespace raybundle {
namespace {

using linalg::index;

using linalg::CholeskyKind;

std::optional<CholeskyKind> kind(std::optional<Linear> linear) {
  if (!linear) return std::nullopt;
  if (*linear == Linear::cholmod) return CholeskyKind::cholmod;
  return *linear == Linear::dense_cholesky ? CholeskyKind::dense : CholeskyKind::sparse;
}

Linear linear_of(CholeskyKind kind) {
  switch (kind) {
    case CholeskyKind::sparse:
      return Linear::sparse_cholesky;
    case CholeskyKind::cholmod:
      return Linear::cholmod;
    case CholeskyKind::dense:
      break;
  }
  return Linear::dense_cholesky;
}

// The step of [Qu18, Eq. 3.55] by factorising the (reduced) matrix.
class CholeskyStep final : public StepSolver {
 public:
  CholeskyStep(const Options& options, const linalg::BlockLayout& layout, linalg::ThreadPool& pool,
               linalg::CholeskyPlan plan)
      : elimination_(*options.elimination),
        matrix_memory_(plan.memory),
        system_(make_reduced_system(layout, eliminated_side(*options.elimination), pool)),
        cholesky_(linalg::Cholesky::make(std::move(plan), pool)),
        x_(index(system_->size())) {}

  StepReport solve(const StepRequest& request, double* step) override {
    system_->prepare(request.at, request.damping);
    system_->assemble(cholesky_->matrix(), x_.data());
    for (double& x : x_) x = -x;
    if (!cholesky_->factor()) return {.eliminated = elimination_};
    cholesky_->solve(x_.data());
    const double curvature = system_->expand(x_.data(), step);
    return {.solved = true, .eliminated = elimination_, .curvature = curvature};
  }

  Linear linear() const override { return linear_of(cholesky_->kind()); }
  double matrix_memory() const override { return matrix_memory_; }
  std::string description() const override { return cholesky_->description(); }

 private:
  Elimination elimination_;
  double matrix_memory_;
  std::unique_ptr<linalg::ReducedSystem> system_;
  std::unique_ptr<linalg::Cholesky> cholesky_;
  std::vector<double> x_;
};

}  // namespace

std::unique_ptr<StepSolver> make_cholesky_step(const Options& options,
                                               const linalg::BlockLayout& layout,
                                               linalg::ThreadPool& pool) {
  const auto side = eliminated_side(*options.elimination);
  linalg::SymmetricPattern pattern = side ? linalg::reduced_pattern(layout, *side, pool)
                                          : make_reduced_system(layout, side, pool)->pattern();
  linalg::CholeskyPlan plan =
      linalg::plan_cholesky(std::move(pattern), pool.threads(), kind(options.linear));
  linalg::require_memory(plan.memory, options.memory_limit,
                         "factorising a matrix of order " + std::to_string(plan.pattern.order()));
  return make_cholesky_step(options, layout, pool, std::move(plan));
}

// What elimination none copies: the diagonal blocks of a side at a time.
double cholesky_step_memory(const Options& options, const linalg::LayoutSize& n) {
  const auto side = eliminated_side(*options.elimination);
  const double system = reduced_system_memory(n, side, true);
  if (side) return system + 8 * static_cast<double>(n.size(opposite(*side)));
  const auto blocks = static_cast<double>(n.size(linalg::Side::leaves) * n.block.leaf);
  return system + 8 * (static_cast<double>(n.unknowns()) + blocks);
}

std::unique_ptr<StepSolver> make_cholesky_step(const Options& options,
                                               const linalg::BlockLayout& layout,
                                               linalg::ThreadPool& pool,
                                               linalg::CholeskyPlan plan) {
  return std::make_unique<CholeskyStep>(options, layout, pool, std::move(plan));
}

}  // namespace raybundle
