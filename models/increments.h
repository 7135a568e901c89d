#pragma once

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/point_model.h>
#include <raybundle/models/problem.h>

#include <array>
#include <vector>

/// Finite-difference increments: how far a parameter must move for its effect to show, and
/// therefore how sensitive it is [Qu18, 3.1.4].
namespace raybundle {

/// The kinds of parameter, in the order of their increments. Points as coordinates have the kind
/// point, anchored ones parallax and direction.
enum class ParameterKind { rotation, translation, focal, k1, k2, point, parallax, direction };
inline constexpr int parameter_kinds = 8;
const char* name(ParameterKind kind);
/// Whether a problem whose points are described so has parameters of this kind.
bool has_kind(PointModel model, ParameterKind kind);

/// One increment per kind of parameter; [Qu18, Eq. 3.38], whose printed vector is damaged, holds
/// the author's. Those that do not belong to the description of the points are 0.
struct Increments {
  double rotation = 0;     ///< radians
  double translation = 0;  ///< the world's unit of length
  double focal = 0;        ///< pixels
  double k1 = 0;
  double k2 = 0;
  double point = 0;      ///< the world's unit of length
  double parallax = 0;   ///< radians; idp: inverse distance, one over the unit of length
  double direction = 0;  ///< radians
};
double increment(const Increments& increments, ParameterKind kind);

/// What search_increments() finds on a street-level data set (docs/increments.md).
Increments shipped_increments(PointModel points);

/// What the search saw of one kind.
struct IncrementTrial {
  double step;
  double error;  ///< |numeric - analytic| / |analytic|, Frobenius norms over all derivatives
};
struct IncrementSearch {
  /// By kind, large steps first; empty where the problem has none of the kind.
  std::array<std::vector<IncrementTrial>, parameter_kinds> trials;
  double attainable = 0;  ///< the least error of the kind that is hardest to differentiate
  Increments found;
};

/// Compares forward differences, over steps of 10^0 to 10^-12, with the analytic Jacobian at the
/// problem's own state (global pose update, lenses free). A kind's increment is the smallest step
/// that is as accurate as the hardest kind at its best: the projection is linear in f, k1 and k2,
/// whose differences only gain from larger steps, so "the best step" would mean nothing for them.
/// Rows of anchored points depend on several cameras: all are moved at once, every second one the
/// other way, so that their effects do not cancel. Throws InputError when the problem is
/// inconsistent or its derivatives are not finite.
IncrementSearch search_increments(const Problem& problem, PointModel points,
                                  linalg::ThreadPool& pool);

}  // namespace raybundle
