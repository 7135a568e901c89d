#pragma once

#include <algorithm>

#include <raybundle/models/problem.h>

namespace raybundle::test {

/// What is seen, without any pose or point.
inline Problem forgotten(Problem problem) {
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
    if (i % 9 < 6) problem.cameras[i] = 0;
  }
  std::fill(problem.points.begin(), problem.points.end(), 0.0);
  return problem;
}

}  // namespace raybundle::test
