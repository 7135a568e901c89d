#pragma once

#include <raybundle/linalg/cholesky.h>
#include <raybundle/linalg/reduced_system.h>
#include <raybundle/solver/forcing.h>
#include <raybundle/solver/options.h>
#include <raybundle/solver/summary.h>

#include <limits>
#include <memory>
#include <optional>
#include <string>

namespace raybundle {

/// What a step is computed from.
struct StepRequest {
  linalg::Linearization at;
  bool relinearised = true;       ///< false: `at` is as it was in the request before
  const double* damping;          ///< the diagonal mu D, all unknowns
  const double* inverse_scaling;  ///< D^-1 of [Qu18, Eq. 3.94], all unknowns; null: the identity
  double radius = std::numeric_limits<double>::infinity();  ///< |D p| of the unknowns solved for
  /// |D p| of each eliminated block: nothing else holds a step of theirs without damping.
  std::optional<double> block_radius = {};
  InnerTolerance tolerance = {};  ///< of inner iterations
  double grown = 0;               ///< bytes that all else takes more than when the steps were made
};

struct StepReport {
  bool solved = false;  ///< false: the system could not be factorised, or broke down at once
  int inner_iterations = 0;
  bool two_level = false;       ///< they had a coarse space from the first on ...
  bool two_level_next = false;  ///< ... and those of the next step will have one
  bool inner_capped = false;    ///< they were at their limit
  bool on_boundary = false;     ///< the trust region cut the step
  double length = 0;            ///< |D p| over the unknowns solved for; 0 where there is no region
  bool block_on_boundary = false;  ///< the block radius mattered
  double block_length = 0;         ///< what it may be after this step; 0 where there is none
  Elimination eliminated = Elimination::points;
  std::optional<double> curvature = {};  ///< |J p|^2, where the solve found it on its way
  int linear_solves = 1;
  /// A multiple of diag(H) that was added where the normal equations could not be factorised.
  double regularisation = 0;
  double condition_cameras = std::numeric_limits<double>::quiet_NaN();  ///< worst block of B, and
  double condition_points = std::numeric_limits<double>::quiet_NaN();   ///< C; adinm only
};

/// Solves (H + mu D) p = -g, exactly or not, or minimises that quadratic within a trust region.
class StepSolver {
 public:
  virtual ~StepSolver() = default;

  /// `step` receives p for all unknowns.
  virtual StepReport solve(const StepRequest& request, double* step) = 0;
  virtual Linear linear() const = 0;
  /// Bytes of an explicit matrix with its factor.
  virtual double matrix_memory() const { return 0; }
  /// What does the work, for people.
  virtual std::string description() const = 0;
  /// What it was chosen from; empty where it was told.
  virtual LinearChoice choice() const { return {}; }
};

/// The one that `options` (resolved) ask for; layout and pool outlive it. Here the memory limit is
/// what a matrix with its factor may take. Throws std::bad_alloc when its matrices cannot be held.
std::unique_ptr<StepSolver> make_step_solver(const Options& options,
                                             const linalg::BlockLayout& layout,
                                             linalg::ThreadPool& pool);

std::unique_ptr<StepSolver> make_cholesky_step(const Options& options,
                                               const linalg::BlockLayout& layout,
                                               linalg::ThreadPool& pool);
/// The same where the plan is made already.
std::unique_ptr<StepSolver> make_cholesky_step(const Options& options,
                                               const linalg::BlockLayout& layout,
                                               linalg::ThreadPool& pool, linalg::CholeskyPlan plan);
std::unique_ptr<StepSolver> make_automatic_step(const Options& options,
                                                const linalg::BlockLayout& layout,
                                                linalg::ThreadPool& pool);
std::unique_ptr<StepSolver> make_dogleg_step(const Options& options,
                                             const linalg::BlockLayout& layout,
                                             linalg::ThreadPool& pool);
std::unique_ptr<StepSolver> make_pcg_step(const Options& options, Elimination elimination,
                                          const linalg::BlockLayout& layout,
                                          linalg::ThreadPool& pool);
/// The same on a matrix that is formed, where its sparsity is known already.
std::unique_ptr<StepSolver> make_explicit_pcg_step(const Options& options, Elimination elimination,
                                                   const linalg::BlockLayout& layout,
                                                   linalg::ThreadPool& pool,
                                                   linalg::SymmetricPattern pattern);
std::unique_ptr<StepSolver> make_adaptive_step(const Options& options,
                                               const linalg::BlockLayout& layout,
                                               linalg::ThreadPool& pool);

/// Bytes of the one that `options` ask for, without an explicit matrix.
double step_memory(const Options& options, const linalg::LayoutSize& n);
double cholesky_step_memory(const Options& options, const linalg::LayoutSize& n);
double dogleg_step_memory(const Options& options, const linalg::LayoutSize& n);
double pcg_step_memory(const Options& options, Elimination elimination,
                       const linalg::LayoutSize& n);
double adaptive_step_memory(const Options& options, const linalg::LayoutSize& n);

/// Preconditioner::adaptive goes over to two levels after a step of more inner iterations than
/// these, and within one of too many. A coarse space costs about as much as 15 of them.
inline constexpr int many_inner_iterations = 30;
inline constexpr int too_many_inner_iterations = 60;

/// Whether steps may ask for Linearization::hub_modes.
bool has_coarse_space(const Options& options);

/// The side whose blocks an elimination removes.
std::optional<linalg::Side> eliminated_side(Elimination elimination);

}  // namespace raybundle
