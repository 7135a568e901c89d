#pragma once

#include <raybundle/models/lens.h>
#include <raybundle/models/pose.h>

#include <limits>
#include <optional>
#include <string>

namespace raybundle {

/// A row of the method table (solver/methods.h).
enum class Method { lm_cholesky, tnm };
/// Which side of the normal equations is eliminated before the inner solve.
enum class Elimination { none, points, cameras };
/// How the (reduced) linear system is solved.
enum class Linear { dense_cholesky, sparse_cholesky, implicit_pcg };
/// Preconditioners of [Qu18, 3.3.5]; B and S are the undiminished and the Schur-reduced matrix of
/// the side that is kept.
enum class Preconditioner { identity, diag_b, b, diag_s, block_diag_s };
/// The diagonal matrix that is added (damping) or that scales the unknowns.
enum class DiagonalMatrix { identity, diag_h };

/// Everything that shapes a solve; use designated initialisers. An empty optional means: as the
/// method prefers. solver/option_table.h holds each option's name, range and help.
struct Options {
  Method method = Method::lm_cholesky;
  std::optional<Elimination> elimination = {};        ///< empty: points
  std::optional<Linear> linear = {};                  ///< empty: by predicted work
  std::optional<Preconditioner> preconditioner = {};  ///< tnm; empty: block_diag_s, b for none
  std::optional<DiagonalMatrix> damping_matrix = {};  ///< empty: diag_h
  std::optional<DiagonalMatrix> scaling = {};         ///< empty: identity
  PoseUpdate pose_update = PoseUpdate::local;
  Lens lens = Lens::free;

  int max_iterations = 50;  ///< trial steps, rejected ones included
  double time_limit = std::numeric_limits<double>::infinity();  ///< seconds
  double function_tolerance = 1e-6;                             ///< |cost change| over cost
  double gradient_tolerance = 1e-10;                            ///< largest entry of J^T r
  double parameter_tolerance = 1e-8;  ///< |step| over |block|, the largest of all blocks
  int max_consecutive_failures = 12;  ///< rejected steps in a row

  double initial_damping = 1e-4;  ///< mu of [Qu18, Alg. 6]
  double min_damping = 1e-16;
  double max_damping = 1e32;

  std::optional<int> max_inner_iterations = {};  ///< tnm; empty: 1000
  std::optional<double> forcing = {};            ///< tnm, t of [Qu18, Alg. 1]; empty: 0.1

  int threads = 0;  ///< 0: all cores
};

/// The names an enumeration has on the command line, in logs and in documentation.
const char* name(Method value);
const char* name(Elimination value);
const char* name(Linear value);
const char* name(Preconditioner value);
const char* name(DiagonalMatrix value);
const char* name(PoseUpdate value);
const char* name(Lens value);

/// Fills every empty choice with what the method prefers and checks ranges and combinations.
/// Throws OptionError for a value out of range, or for an option that would have no effect.
Options resolve(const Options& options);

}  // namespace raybundle
