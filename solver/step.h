#pragma once

#include <raybundle/linalg/reduced_system.h>
#include <raybundle/solver/options.h>

#include <memory>
#include <string>

namespace raybundle {

struct StepReport {
  bool solved = false;  ///< false: the system could not be factorised
  int inner_iterations = 0;
};

/// Solves (H + D) p = -g, exactly or not.
class StepSolver {
 public:
  virtual ~StepSolver() = default;

  /// `damping` is the diagonal D; `step` receives p for all unknowns.
  virtual StepReport solve(const linalg::Linearization& at, const double* damping,
                           double* step) = 0;
  virtual Linear linear() const = 0;
  /// What does the work, for people.
  virtual std::string description() const = 0;
};

/// The one that `options` (resolved) ask for; layout and pool outlive it. Throws std::bad_alloc
/// when its matrices cannot be held.
std::unique_ptr<StepSolver> make_step_solver(const Options& options,
                                             const linalg::BlockLayout& layout,
                                             linalg::ThreadPool& pool);

std::unique_ptr<StepSolver> make_cholesky_step(const Options& options,
                                               const linalg::BlockLayout& layout,
                                               linalg::ThreadPool& pool);
std::unique_ptr<StepSolver> make_pcg_step(const Options& options, const linalg::BlockLayout& layout,
                                          linalg::ThreadPool& pool);

/// The side whose blocks an elimination removes.
std::optional<linalg::Side> eliminated_side(Elimination elimination);

/// 1 / D for the scaled unknowns D x of [Qu18, Eq. 3.94]; D^T D is the chosen matrix, as in
/// [Qu18, Eq. 2.52]. Empty for the identity.
void inverse_scaling(DiagonalMatrix scaling, const linalg::NormalEquations& normal,
                     std::vector<double>& inverse);

/// diag(H) is kept within these bounds wherever it damps or scales.
constexpr double min_diagonal = 1e-6;
constexpr double max_diagonal = 1e32;

}  // namespace raybundle
