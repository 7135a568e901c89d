#pragma once

#include <cstdint>

#include <raybundle/models/problem.h>

namespace raybundle::test {

/// What a small random problem is made of. Cameras stand on a cap around the origin, look at it
/// with any roll, and have mild lenses; points lie within a unit or two of it.
struct SmallProblemOptions {
  std::uint64_t seed = 1;
  int cameras = 4;                 ///< all cameras, unobserved ones included
  int points = 20;                 ///< all points, the special ones below included
  int observations_per_point = 3;  ///< distinct cameras per ordinary point (at most the observed)
  int duplicate_observations = 0;  ///< extra observations of a pair that is there already
  int unobserved_cameras = 0;      ///< the last cameras
  int unobserved_points = 0;       ///< the last points
  int points_seen_once = 0;        ///< the first points: their block C_i has rank 2
  int far_points = 0;              ///< the next: all rays parallel, C_i numerically of rank 2
  double pixel_noise = 0.5;        ///< of the observations, pixels; 0: the truth fits exactly
  double parameter_noise = 0.01;   ///< of poses and points; 0: the start is the truth
  bool shuffled = false;           ///< observations in random order instead of by point
};

/// A small problem that is well posed but for the gauge, unless the options ask otherwise.
/// Throws std::invalid_argument when the counts do not fit together.
Problem small_problem(const SmallProblemOptions& options = {});

}  // namespace raybundle::test
