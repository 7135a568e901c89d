#pragma once

#include <raybundle/models/problem.h>

/// Synthetic scenes: problems made from a seed, the same bits on every machine and compiler.
namespace raybundle::scenes {

/// What there is to see, and what cameras without any error see of it. Noise (noise.h) comes after.
struct Scene {
  Problem truth;            ///< true cameras and points, exact observations: cost 0 to rounding
  double image_width = 0;   ///< pixels; all observations lie in this rectangle ...
  double image_height = 0;  ///< ... around the centre of the image
};

}  // namespace raybundle::scenes
