#pragma once

#include <cstdint>
#include <random>

#include <raybundle/models/problem.h>

namespace raybundle::test {

/// Uniform in [-1, 1), from the top 53 bits: the same on every machine, unlike the distributions of
/// the standard library.
inline double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1;
}

/// A valid problem of random numbers, for the formats; it is not a scene.
inline Problem random_problem(std::uint64_t seed, int cameras, int points, int observations) {
  std::mt19937_64 random(seed);
  const auto below = [&](int count) {
    return static_cast<std::int32_t>(random() % static_cast<std::uint64_t>(count));
  };
  Problem problem;
  for (int i = 0; i < observations; ++i) {
    problem.observation_camera.push_back(below(cameras));
    problem.observation_point.push_back(below(points));
    problem.observations.push_back(1000 * uniform(random));
    problem.observations.push_back(1000 * uniform(random));
  }
  for (int i = 0; i < Problem::camera_size * cameras; ++i) {
    problem.cameras.push_back(uniform(random));
  }
  for (int i = 0; i < Problem::point_size * points; ++i) {
    problem.points.push_back(10 * uniform(random));
  }
  return problem;
}

}  // namespace raybundle::test
