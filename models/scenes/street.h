#pragma once

#include <raybundle/models/problem.h>

#include <cstdint>

/// Synthetic scenes: problems made from a seed, the same bits on every machine and compiler.
namespace raybundle::scenes {

/// A camera driving down a street of house fronts, looking forward, with far features ahead.
/// Lengths are in steps, the distance between one camera and the next.
struct StreetOptions {
  std::uint64_t seed = 1;
  std::int64_t cameras = 30;
  std::int64_t points = 3000;
  double pixel_noise = 0.5;       ///< standard deviation of the observations, pixels
  double rotation_noise = 0.005;  ///< of the starting rotation vectors, radians
  double position_noise = 0.1;    ///< of the starting camera centres, steps
  double point_noise = 0.01;      ///< of the starting points, relative to their depth
};

/// A problem with its known answer. Both hold the same noisy observations.
struct StreetScene {
  Problem start;  ///< perturbed poses and points, nominal lenses
  Problem truth;  ///< what the observations were made from
};

/// Every point is seen by at least two cameras. Throws InputError for counts below 2 cameras or
/// 1 point, counts a 32-bit index cannot hold, and noise that is negative or not finite.
StreetScene street_scene(const StreetOptions& options = {});

/// The start alone: the problem to solve.
Problem street(const StreetOptions& options = {});

}  // namespace raybundle::scenes
