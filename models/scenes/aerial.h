#pragma once

#include <raybundle/models/scenes/scene.h>

#include <cstdint>

namespace raybundle::scenes {

/// A survey flight: images straight down from a grid of positions over gentle hills, in strips
/// flown to and fro. Lengths are in steps, the distance between images of a strip.
struct AerialOptions {
  std::uint64_t seed = 1;
  std::int64_t cameras = 60;
  std::int64_t points = 3000;
  std::int64_t observations = 0;  ///< 0: all of those that see a point, about 12
  double height = 20;             ///< above the ground: the higher, the smaller the parallax
};

/// Every point is seen by at least two cameras. Observations are as many as asked for unless the
/// geometry cannot give so many. Throws InputError for counts below 2 cameras or 1 point, counts a
/// 32-bit index cannot hold, a number of observations that is impossible, and a height outside 1 to
/// 1e6.
Scene aerial_scene(const AerialOptions& options = {});

}  // namespace raybundle::scenes
