#pragma once

#include <raybundle/solver/options.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace raybundle {

/// Why a solve ended.
enum class Termination {
  gradient_tolerance,    ///< converged: the gradient vanished
  function_tolerance,    ///< converged: the cost no longer falls
  parameter_tolerance,   ///< converged: the unknowns no longer move
  max_iterations,        ///< limit reached
  time_limit,            ///< limit reached
  stopped,               ///< the observer asked for it
  damping_limit,         ///< the damping is at its limit and no step lowers the cost
  radius_limit,          ///< the trust region is at its limit and no step lowers the cost
  consecutive_failures,  ///< too many rejected steps in a row
  bad_start,             ///< cost or gradient of the start is not finite
  out_of_memory,         ///< something could not be allocated on the way
};
const char* name(Termination value);

/// How a solve ended, coarsely; the command line's exit code follows from it.
enum class Outcome { converged, limit_reached, interrupted, failed };
Outcome outcome(Termination value);

/// Eigenvalues of a linearisation without damping: how well it determines the points while cameras
/// stay (the blocks C of H), and the cameras with points following them (S_C). What is fixed is
/// left out; the seven freedoms of a free gauge are not.
struct Diagnosis {
  double points_smallest = 0;         ///< of all points
  double points_largest = 0;          ///< of all points
  double points_worst_condition = 1;  ///< of a single point's block
  double reduced_smallest = 0;        ///< 0: not positive definite as far as rounding tells
  double reduced_largest = 0;
};

/// One trial step. Iteration 0 is the start. "cost" and "gradient_norm" belong to the state that
/// is kept after the iteration.
struct IterationRecord {
  int iteration = 0;
  bool accepted = false;
  double cost = 0;
  double pixel_cost = std::numeric_limits<double>::quiet_NaN();  ///< of the same state, without a
                                                                 ///< loss; NaN where "cost" is of
                                                                 ///< pixels
  double candidate_cost = 0;      ///< of the trial; NaN when it could not be evaluated
  double predicted_decrease = 0;  ///< of the quadratic model [Qu18, Eq. 3.102]
  double gradient_norm = 0;       ///< Euclidean
  double gradient_max = 0;        ///< largest absolute entry
  double step_norm = 0;           ///< Euclidean
  double relative_step = 0;       ///< largest, over blocks, of |step| / (|block| + tolerance)
  double rho = 0;                 ///< actual over predicted decrease [Qu18, Eq. 3.104]
  double damping = 0;             ///< mu of this trial; 0 where the method has none
  double radius = 0;              ///< of this trial's trust region; 0 where the method has none
  bool on_boundary = false;       ///< the trust region cut the step
  double regularisation = 0;      ///< share of diag(H) added to factorise at all; dogleg only
  std::int64_t points_held = 0;   ///< points that stayed, see PointSteps
  int inner_iterations = 0;
  bool inner_capped = false;  ///< the inner iterations were at their limit
  Elimination eliminated = Elimination::none;
  double condition_cameras = 0;  ///< worst of a damped block of B; NaN where nobody asks for it
  double condition_points = 0;   ///< worst of a damped block of C; NaN likewise
  /// Of the state that is kept, after an accepted step; on request only.
  std::optional<Diagnosis> diagnosis = {};
  double loss_scale = 0;  ///< pixels, of "cost"; 0 where there is no loss
  double seconds = 0;     ///< since the start of the solve
};

/// What iterating in one step takes, or is expected to.
struct InnerIterations {
  int count = 10;          ///< of a first step
  bool two_level = false;  ///< with a coarse space
};

/// A way to solve the linear systems, as predicted from sizes: work in multiplications.
struct LinearCandidate {
  Linear linear = Linear::dense_cholesky;
  double work = 0;           ///< of a step beside its inner iterations
  double inner_work = 0;     ///< of an inner iteration
  double coarse_work = 0;    ///< of a coarse space for them
  double memory = 0;         ///< bytes of matrix and factor
  bool lower_bound = false;  ///< the sparsity of the matrix was not asked for: no need
  bool fits = true;          ///< into memory

  double work_with(InnerIterations expected) const {
    return work + expected.count * inner_work + (expected.two_level ? coarse_work : 0);
  }
};

/// What `auto` chose from, and what it expected; empty where nothing was left to choose.
struct LinearChoice {
  std::vector<LinearCandidate> candidates;
  InnerIterations expected;
};

/// Seconds by phase.
struct Timing {
  double total = 0;
  double setup = 0;      ///< layout, orderings, allocation
  double residual = 0;   ///< cost of candidates
  double jacobian = 0;   ///< residuals with derivatives, gradient, block diagonals
  double diagnosis = 0;  ///< eigenvalues, on request
  double linear = 0;     ///< damping, elimination, inner solves, back-substitution
};

/// What a solve did. The best state is in the Problem that was passed.
struct [[nodiscard]] Summary {
  Options options;  ///< effective: every choice filled in
  Termination termination = Termination::bad_start;
  std::string message;  ///< the reason in words
  double initial_cost = 0;
  double final_cost = 0;
  double rounding = 0;       ///< what a cost may be for the rounding of the observations alone
  double gradient_norm = 0;  ///< at the end
  int accepted = 0;
  int linear_solves = 0;
  int regularised = 0;  ///< linearisations whose normal equations were singular; dogleg only
  std::int64_t inner_iterations = 0;
  int threads = 1;  ///< used
  Timing seconds;
  int widened_at = -1;  ///< iteration after which rows of J went from single to double precision
  std::string linear_solver;  ///< what solved the linear systems, in words
  LinearChoice linear_choice;
  std::vector<IterationRecord> iterations;

  bool usable() const { return outcome(termination) != Outcome::failed; }
};

}  // namespace raybundle
