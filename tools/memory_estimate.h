#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <raybundle/models/problem.h>
#include <raybundle/solver/options.h>

namespace raybundle::tools {

/// What is known of a number of bytes where the sparsity of a matrix was not worked out: with a
/// full one, or without what its factorisation fills in.
enum class Bound { none, at_most, at_least };

/// What one way to solve a problem is expected to take at most at a time, the problem included.
struct MemoryEstimate {
  Method method;
  PointModel points;
  std::optional<Elimination> elimination;  ///< empty: the method chooses
  Linear linear;
  double bytes;
  Bound bound;
  /// With a coarse space too, which Preconditioner::adaptive has where inner iterations are many.
  std::optional<double> bytes_of_two_levels;
};

/// The system of the cameras that is left when the points are eliminated.
struct ReducedShape {
  std::int64_t order = 0;
  double fill = 0;  ///< share of its camera pairs whose block is not zero
};

struct MemoryEstimates {
  ReducedShape reduced;
  std::vector<MemoryEstimate> methods;
};

/// With the points as coordinates, and for dogleg by parallax. Works out the sparsity of the
/// reduced system and its factor where that fits, hence takes memory itself, but less than a solve.
MemoryEstimates estimate_memory(const Problem& problem, Lens lens);

}  // namespace raybundle::tools
