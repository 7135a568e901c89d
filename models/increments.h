#pragma once

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/problem.h>

#include <array>
#include <vector>

/// Finite-difference increments: how far a parameter must move for its effect to show, and
/// therefore how sensitive it is [Qu18, 3.1.4].
namespace raybundle {

/// The kinds of parameter, in the order of their increments.
enum class ParameterKind { rotation, translation, focal, k1, k2, point };
inline constexpr int parameter_kinds = 6;
const char* name(ParameterKind kind);

/// One increment per kind of parameter; [Qu18, Eq. 3.38], whose printed vector is damaged, holds
/// the author's. The defaults are what search_increments() finds on a street-level data set
/// (docs/increments.md).
struct Increments {
  double rotation = 1e-9;     ///< radians
  double translation = 1e-9;  ///< the world's unit of length
  double focal = 1e-6;        ///< pixels
  double k1 = 1e-9;
  double k2 = 1e-9;
  double point = 1e-9;  ///< the world's unit of length
};

/// What the search saw of one kind.
struct IncrementTrial {
  double step;
  double error;  ///< |numeric - analytic| / |analytic|, Frobenius norms over all derivatives
};
struct IncrementSearch {
  std::array<std::vector<IncrementTrial>, parameter_kinds> trials;  ///< by kind, large steps first
  double attainable = 0;  ///< the least error of the kind that is hardest to differentiate
  Increments found;
};

/// Compares forward differences, over steps of 10^0 to 10^-12, with the analytic Jacobian at the
/// problem's own state (global pose update, lenses free). A kind's increment is the smallest step
/// that is as accurate as the hardest kind at its best: the projection is linear in f, k1 and k2,
/// whose differences only gain from larger steps, so "the best step" would mean nothing for them.
/// Throws InputError when the problem is inconsistent or its derivatives are not finite.
IncrementSearch search_increments(const Problem& problem, linalg::ThreadPool& pool);

}  // namespace raybundle
