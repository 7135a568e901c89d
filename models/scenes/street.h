#pragma once

#include <raybundle/models/scenes/scene.h>

#include <cstdint>

namespace raybundle::scenes {

/// A camera driving down a street of house fronts, looking forward, with far features ahead.
/// Lengths are in steps, the distance between one camera and the next.
struct StreetOptions {
  std::uint64_t seed = 1;
  std::int64_t cameras = 30;
  std::int64_t points = 3000;
  std::int64_t observations = 0;  ///< 0: what the geometry gives
  double far_share = 0.1;         ///< of the features that are hundreds of steps ahead, 0 to 1
  double collinear_share = 0;     ///< of the points, on the line along which the cameras that see
                                  ///< them move, 0 to 1
  std::int64_t lap = 0;           ///< steps round the block, then the same way again; 0: no loop
};

/// Every point is seen by at least two cameras. Observations are as many as asked for unless the
/// geometry cannot give so many. Throws InputError for counts below 2 cameras or 1 point, counts a
/// 32-bit index cannot hold, a number of observations that is impossible, shares outside 0 to 1,
/// and a lap that is neither 0 nor a multiple of 4 of at least 160.
Scene street_scene(const StreetOptions& options = {});

/// The small problem at hand for a first solve: the scene with 0.5 pixels of noise, as its cameras
/// start with errors of 0.005 radians and 0.1 steps and the nominal lens, its points with errors of
/// 1 % of their depth. These errors are drawn with the scene, other than those of noise.h.
Problem street(const StreetOptions& options = {});

}  // namespace raybundle::scenes
