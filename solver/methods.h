#pragma once

#include <raybundle/solver/options.h>

namespace raybundle {

/// How a method solves the linear system of a step.
enum class InnerSolve { cholesky, pcg };

/// A method is a row of choices over independent axes; nothing but this table knows its name.
struct MethodTraits {
  Method method;
  const char* name;
  const char* help;
  InnerSolve inner;
  Elimination elimination;        ///< what it eliminates unless told otherwise
  Preconditioner preconditioner;  ///< what its inner iterations use (PCG only)
  DiagonalMatrix damping_matrix;
  DiagonalMatrix scaling;
  double forcing;            ///< t of the PCG stop test
  int max_inner_iterations;  ///< PCG only
};

const MethodTraits& traits(Method method);

}  // namespace raybundle
