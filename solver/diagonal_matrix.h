#pragma once

#include <raybundle/linalg/normal_equations.h>
#include <raybundle/models/increments.h>
#include <raybundle/solver/options.h>

namespace raybundle {

/// diag(H) is kept within these bounds wherever it damps or scales.
constexpr double min_diagonal = 1e-6;
constexpr double max_diagonal = 1e32;
constexpr double held_share = 0.1;

/// Whether it follows the linearisation, and has the units of H.
constexpr bool is_of_h(DiagonalMatrix kind) {
  return kind == DiagonalMatrix::diag_h || kind == DiagonalMatrix::held_h;
}

/// Writes the chosen matrix to `d`, one number per unknown:
///   identity  1
///   inc       (increment of points / increment of the unknown)^2: unknowns that act more per unit
///             than a point's coordinate weigh more  [Qu18, Eq. 3.38 and 3.3.3, "Scaling"]; of
///             anchored points the unit is their direction
///   diag_h    diag(H), within bounds  [Qu18, Eq. 2.50]
///   held_h    the same, and of a point in coordinates no entry below held_share of its largest:
///             diag(H) leaves the depth of a far point free where it runs along an axis
/// As damping matrix it is D of [Qu18, Eq. 2.49]. As scaling p~ = D p of [Qu18, Eq. 3.94] it is D^T
/// D, like D' in [Qu18, Eq. 2.52]: taken literally, D = diag(H) would mix units.
void fill_diagonal(DiagonalMatrix kind, const Increments& increments, PointModel points,
                   const linalg::NormalEquations& normal, linalg::LargeVector<double>& d,
                   linalg::ThreadPool& pool);

/// The increments that `options` ask for.
Increments increments(const Options& options);

}  // namespace raybundle
