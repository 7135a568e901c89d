#pragma once

#include <raybundle/models/scenes/scene.h>

#include <cstdint>

namespace raybundle::scenes {

/// Photographs that many people took of a few sights, as community collections have them: popular
/// and lonely sights, close-ups and overviews, all sorts of lenses, images that see very much
/// (hubs) and a heavy tail of track lengths. The sights stand in a row, overviews link them.
struct PhotosOptions {
  std::uint64_t seed = 1;
  std::int64_t cameras = 60;
  std::int64_t points = 3000;
  std::int64_t observations = 0;  ///< 0: four per point
  std::int64_t sights = 0;        ///< 0: one per 60 cameras
};

/// Every point is seen by at least two cameras. Observations are as many as asked for unless the
/// geometry cannot give so many. Throws InputError for counts below 2 cameras or 1 point, counts a
/// 32-bit index cannot hold, a number of observations that is impossible, more sights than half the
/// cameras, and cameras that have no points in common.
Scene photos_scene(const PhotosOptions& options = {});

}  // namespace raybundle::scenes
