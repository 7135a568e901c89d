#pragma once

#include <raybundle/models/random.h>

#include <cstdint>
#include <vector>

namespace raybundle::scenes {

/// Lengths of `points` tracks, 2 to `longest`, that add up to `observations` where they can, in
/// random order. Their shares fall as theta^L / L^2, with the theta that gives their mean. With
/// theta from 0.86 to 0.97 the tracks of three files of Bundle Adjustment in the Large (Ladybug 49,
/// Trafalgar 21, Dubrovnik 16) are distributed like this: their cumulative shares differ by 0.035,
/// 0.028 and 0.069 at most. Larger problems keep the heavy tail.
std::vector<std::int32_t> draw_track_lengths(std::int64_t points, std::int64_t observations,
                                             std::int64_t longest, Random& random);

/// Hands out such lengths to points that may be seen by fewer cameras than they should be.
class TrackPlan {
 public:
  /// Without observations there is no plan.
  TrackPlan(std::int64_t points, std::int64_t observations, std::int64_t longest, Random& random);

  bool exists() const { return !lengths_.empty(); }
  /// Length that point i should have, with something of what its forerunners lacked. Points come
  /// in order.
  std::int64_t wanted(std::int64_t i) const;
  /// Length for point i, which `available` cameras see. What it lacks others make up for.
  std::int64_t settle(std::int64_t i, std::int64_t available, Random& random);

 private:
  std::vector<std::int32_t> lengths_;
  std::int64_t missing_ = 0;
};

}  // namespace raybundle::scenes
