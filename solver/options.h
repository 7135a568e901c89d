#pragma once

#include <raybundle/linalg/precision.h>
#include <raybundle/models/formulation.h>
#include <raybundle/models/robust_loss.h>

#include <limits>
#include <optional>
#include <string>

namespace raybundle {

/// A row of the method table (solver/methods.h).
enum class Method { automatic, lm_cholesky, tnm, inm, dinm, adinm, dogleg, irls };
/// Which side of the normal equations is eliminated before the inner solve.
enum class Elimination { none, points, cameras };
/// How the (reduced) linear system is solved.
enum class Linear { dense_cholesky, sparse_cholesky, cholmod, explicit_pcg, implicit_pcg };
/// Whether that is conjugate gradients, on the matrix or without forming it, and no factorisation.
constexpr bool iterates(Linear linear) { return linear >= Linear::explicit_pcg; }
/// Preconditioners of [Qu18, 3.3.5], where B and S are the undiminished and the Schur-reduced
/// matrix of the side that is kept; and beyond: block-diag-s with a coarse space of camera clusters
/// (linalg/coarse_space.h), from the first step on or once inner iterations are many.
enum class Preconditioner { identity, diag_b, b, diag_s, block_diag_s, two_level, adaptive };
/// The diagonal matrix that is added (damping) or that scales the unknowns: see
/// solver/diagonal_matrix.h.
enum class DiagonalMatrix { identity, inc, diag_h, held_h };
/// What ends the inner iterations on A x = b, with t the forcing term:
///   thesis            |A x - b| <= min(t, |b|) |b|                       [Qu18, Alg. 1, 3]
///   constant          |A x - b| <= t |b|
///   eisenstat-walker  |A x - b| <= eta |b|, eta <= t following the gradient [EisenstatWalker96]
///   nash-sofer        the quadratic's decrease by one iteration is at most t of the mean so far
///                     [NashSofer90]
enum class ForcingRule { thesis, constant, eisenstat_walker, nash_sofer };

/// Where points start: as the problem has them, or as far as two of their rays tell
/// [Liu18, Remark 5], which keeps their parallax exactly where coordinates would round it.
enum class PointStart { problem, rays };

/// Which points take their part of a step:
///   all
///   better  those whose own cost it does not raise, the cameras having taken theirs; the others
///           stay for once, and do not spoil a step that is good for all else
///   none    no point moves by itself
/// Anchored points that stay keep direction and parallax, and go with their anchors: with rotations
/// and lenses fixed, `none` is the registration of positions of [Liu18, Eq. 13].
enum class PointSteps { all, better, none };

using linalg::Precision;

/// The increments of the `inc` matrix, one per kind of parameter; empty: those of
/// models/increments.h.
struct IncrementOptions {
  std::optional<double> rotation = {}, translation = {}, focal = {}, k1 = {}, k2 = {};
  std::optional<double> point = {};                     ///< coordinates
  std::optional<double> parallax = {}, direction = {};  ///< anchored points
};

/// Everything that shapes a solve; use designated initialisers. An empty optional means: as the
/// method prefers. solver/option_table.h holds each option's name, range and help.
struct Options {
  Method method = Method::automatic;
  std::optional<Elimination> elimination = {};        ///< empty: points; adinm switches
  std::optional<Linear> linear = {};                  ///< empty: by predicted work
  std::optional<Preconditioner> preconditioner = {};  ///< of the inner iterations
  std::optional<DiagonalMatrix> damping_matrix = {};
  std::optional<DiagonalMatrix> scaling = {};  ///< methods with inner iterations
  PoseUpdate pose_update = PoseUpdate::local;
  std::optional<Lens> lens = {};  ///< empty: free; fixed where the objective is of rays
  PointModel points = PointModel::xyz;
  std::optional<PointStart> point_start = {};  ///< empty: problem
  std::optional<PointSteps> point_steps = {};  ///< empty: all; dogleg: better
  ObjectiveKind objective = ObjectiveKind::pixel;
  std::optional<RayWeight> ray_weight = {};  ///< empty: pixel
  std::optional<Gauge> gauge = {};           ///< empty: free; fixed where nothing damps

  std::optional<Loss> loss = {};             ///< empty: none; irls: tukey
  std::optional<LossScope> loss_scope = {};  ///< empty: observation
  std::optional<double> loss_scale = {};     ///< pixels; empty: default_scale(loss)
  /// Pixels; wide at first, halved down to loss_scale when the solve slows down. Empty: the same as
  /// loss_scale; irls: twice the median residual of the camera that starts worst.
  std::optional<double> loss_start_scale = {};

  int max_iterations = 50;  ///< trial steps, rejected ones included
  double time_limit = std::numeric_limits<double>::infinity();  ///< seconds
  double function_tolerance = 1e-6;                             ///< |cost change| over cost
  double gradient_tolerance = 1e-10;                            ///< largest entry of J^T r
  double parameter_tolerance = 1e-8;  ///< |step| over |block|, the largest of all blocks
  int max_consecutive_failures = 12;  ///< rejected steps in a row

  std::optional<double> initial_damping = {};  ///< mu of [Qu18, Alg. 6]
  std::optional<double> min_damping = {};
  std::optional<double> max_damping = {};
  std::optional<double> initial_radius = {};  ///< empty: the length of the first step, taken freely
  std::optional<double> min_radius = {};

  std::optional<int> max_inner_iterations = {};
  std::optional<ForcingRule> forcing_rule = {};
  std::optional<double> forcing = {};  ///< t of the rule

  /// Of the rows of the Jacobian. Empty: single, and double from where on model and cost disagree
  /// (with `diagnose` double); the summary has what it was in the end.
  std::optional<Precision> precision = {};

  IncrementOptions inc = {};

  /// Bytes that the process may come to, as predicted: more is refused before it is asked for.
  double memory_limit = std::numeric_limits<double>::infinity();

  bool diagnose = false;  ///< eigenvalues of every linearisation: IterationRecord::diagnosis
  int threads = 0;        ///< 0: all cores
};

/// The names an enumeration has on the command line, in logs and in documentation.
const char* name(Method value);
const char* name(Elimination value);
const char* name(Linear value);
const char* name(Preconditioner value);
const char* name(DiagonalMatrix value);
const char* name(ForcingRule value);
const char* name(Loss value);
const char* name(LossScope value);
const char* name(PoseUpdate value);
const char* name(Lens value);
const char* name(PointModel value);
const char* name(PointStart value);
const char* name(PointSteps value);
const char* name(ObjectiveKind value);
const char* name(RayWeight value);
const char* name(Gauge value);
const char* name(Precision value);

/// Fills every empty choice with what the method prefers and checks ranges and combinations.
/// Throws OptionError for a value out of range, or for an option that would have no effect.
Options resolve(const Options& options);

/// Whether a preconditioner is made from the Schur complement.
bool needs_schur_complement(Preconditioner value);

/// What resolved options ask an Objective for.
Formulation formulation(const Options& options);

}  // namespace raybundle
