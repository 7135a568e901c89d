#pragma once

#include <raybundle/models/random.h>
#include <raybundle/models/scenes/camera.h>
#include <raybundle/models/scenes/street.h>

#include <cstdint>
#include <vector>

/// The way down the street of street.h. World frame: x right, y up, the street runs towards -z.
namespace raybundle::scenes {

inline constexpr double nominal_focal_length = 1000;      // pixels
inline constexpr std::int64_t street_corner_length = 20;  // steps, for a right angle
inline constexpr std::int64_t shortest_lap = 4 * (street_corner_length + 20);

/// The cameras in order, a step apart, looking about a little; the path winds, and goes round the
/// block when there is a lap.
std::vector<Camera> drive(const StreetOptions& options, Random& random);

}  // namespace raybundle::scenes
