#pragma once

#include <raybundle/models/problem.h>
#include <raybundle/solver/options.h>

namespace raybundle {

/// Bytes that solve() allocates beside the problem itself and beside an explicit matrix with its
/// factor, which are counted where their sparsity is known (linalg/cholesky.h). `options` are
/// resolved.
double working_memory(const Problem& problem, const Options& options);

/// Bytes of the problem itself.
double problem_memory(const Problem& problem);

}  // namespace raybundle
