#pragma once

#include <raybundle/solver/options.h>
#include <raybundle/solver/trust_radius.h>

namespace raybundle {

/// How a method solves the linear system of a step.
enum class InnerSolve { automatic, cholesky, dogleg, pcg };

/// A method is a row of choices over independent axes; nothing but this table knows its name.
struct MethodTraits {
  Method method;
  const char* name;
  const char* help;
  InnerSolve inner;
  bool damped = true;     ///< has a damping factor mu
  bool bounded = false;   ///< has a trust region (not with Cholesky alone)
  bool adaptive = false;  ///< chooses the eliminated side in every iteration

  // What it prefers where the user leaves the choice:
  Preconditioner preconditioner = Preconditioner::identity;
  DiagonalMatrix damping_matrix = DiagonalMatrix::identity;
  DiagonalMatrix scaling = DiagonalMatrix::identity;
  ForcingRule forcing_rule = ForcingRule::nash_sofer;
  double forcing = 0.1;
  int max_inner_iterations = 1000;
  Gauge gauge = Gauge::free;
  PointSteps point_steps = PointSteps::all;
  RadiusRule radius = {};
  Loss loss = Loss::none;
  bool graduated = false;  ///< starts with a wider loss, as the residuals of the start ask for
};

const MethodTraits& traits(Method method);

constexpr bool has_inner_iterations(const MethodTraits& method) {
  return method.inner == InnerSolve::pcg || method.inner == InnerSolve::automatic;
}

}  // namespace raybundle
