#pragma once

#include <raybundle/models/problem.h>

#include <cstdint>
#include <span>
#include <vector>

namespace raybundle::init {

/// A part of a problem as a problem of its own: some images and points, and the observations of
/// these points in these images.
struct Restriction {
  Problem problem;
  std::vector<std::int32_t> image, point;  ///< in the whole problem
  std::vector<std::int64_t> observation;   ///< likewise

  /// Puts cameras and points back into the whole.
  void write_back(Problem& whole) const;
};

/// Those with a non-zero mark, and of the observations too; points that are left with no
/// observation are left out.
struct Marks {
  std::span<const std::uint8_t> images, points, observations;
};
Restriction restricted(const Problem& problem, const Marks& marks);

}  // namespace raybundle::init
