#pragma once

#include <raybundle/models/random.h>
#include <raybundle/models/scenes/camera.h>

#include <cstdint>
#include <vector>

/// What there is to see in the street of street.h, and which cameras see it.
namespace raybundle::scenes {

inline constexpr double street_image_width = 1280;  // pixels
inline constexpr double street_image_height = 960;

Pixel see(const Camera& camera, const Vec3& X);  ///< X in the world

enum class StreetFeature { front, far, collinear };

struct Feature {
  Vec3 X;
  StreetFeature kind = StreetFeature::front;
  std::int64_t limit = 0;  ///< longest track
};

/// A feature ahead of a camera: on a house front, or far away with probability `far_share`. One
/// whose track is planned to be long is far away, and the farther ahead the longer that is; 0: no
/// plan.
Feature feature_ahead(const Camera& camera, double far_share, std::int64_t planned, Random& random);

/// A feature on the line from camera `anchor` to the one a few steps on, ahead of both.
Feature collinear_feature(const std::vector<Camera>& cameras, std::int64_t anchor,
                          std::int64_t planned, Random& random);

/// Cameras that see a feature, in the order in which a track takes them up.
using Track = std::vector<std::int64_t>;

/// The track of a feature that grows from camera `anchor` forward and backward, on each visit of
/// the place where there is a lap; empty when the anchor does not see it.
Track track_from(std::int64_t anchor, const std::vector<Camera>& cameras, const Feature& feature,
                 std::int64_t lap, Random& random);

/// Puts the camera whose ray to X is farthest from the first one's in second place. Returns the
/// sine of that angle.
double widen(Track& track, const std::vector<Camera>& cameras, const Vec3& X);

}  // namespace raybundle::scenes
