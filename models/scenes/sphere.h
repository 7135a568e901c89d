#pragma once

#include <raybundle/models/scenes/scene.h>

#include <cstdint>

namespace raybundle::scenes {

/// A ball with features all over it, photographed from around [Qu18, 5.1]. The size and the
/// sparsity can be asked for: the fewer the directions the cameras look from, the larger the share
/// of the points that each of them sees.
struct SphereOptions {
  std::uint64_t seed = 1;
  std::int64_t cameras = 10;
  std::int64_t points = 289;
  std::int64_t observations = 0;  ///< 0: what `region` gives; else the region is chosen for them
  double region = 0.6;            ///< cameras stand within this angle of one direction, radians
};

/// Exactly the cameras and points asked for, and the observations up to the rare case that the
/// geometry cannot give so few or many. Cameras are sorted so that neighbours overlap; each
/// is framed by the ball for at least half of its image; each point is seen by two cameras or more.
/// With fewer than three observations per point not all cameras may hang together.
/// Throws InputError for counts below 2 cameras or 1 point or beyond 32-bit indices, a number of
/// observations that is impossible, a region outside 0 to pi, and cameras that have no points in
/// common.
Scene sphere_scene(const SphereOptions& options = {});

}  // namespace raybundle::scenes
