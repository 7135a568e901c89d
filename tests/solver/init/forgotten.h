#pragma once

#include <algorithm>

#include <Eigen/Core>

#include <raybundle/models/alignment.h>
#include <raybundle/models/bal_lens.h>
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

/// The same poses and points, seen without noise.
inline Problem seen_exactly(Problem problem) {
  const auto R_cw = camera_rotations(problem);
  for (std::size_t k = 0; k < problem.observation_camera.size(); ++k) {
    const auto j = static_cast<std::size_t>(problem.observation_camera[k]);
    const double* camera = problem.cameras.data() + 9 * j;
    const double* point = problem.points.data() + std::ptrdiff_t{3} * problem.observation_point[k];
    const Eigen::Vector3d X_c = R_cw[j] * Eigen::Map<const Eigen::Vector3d>(point) +
                                Eigen::Map<const Eigen::Vector3d>(camera + 3);
    bal_lens::project(camera + 6, X_c.data(), problem.observations.data() + 2 * k);
  }
  return problem;
}

/// The observations that keep(camera, point) wants, in order.
template <class Keep>
Problem thinned(const Problem& problem, Keep&& keep) {
  Problem result = problem;
  result.observation_camera.clear(), result.observation_point.clear(), result.observations.clear();
  for (std::size_t k = 0; k < problem.observation_camera.size(); ++k) {
    if (!keep(problem.observation_camera[k], problem.observation_point[k])) continue;
    result.observation_camera.push_back(problem.observation_camera[k]);
    result.observation_point.push_back(problem.observation_point[k]);
    result.observations.insert(result.observations.end(),
                               {problem.observations[2 * k], problem.observations[2 * k + 1]});
  }
  return result;
}

}  // namespace raybundle::test
