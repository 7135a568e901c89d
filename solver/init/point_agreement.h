#pragma once

#include <raybundle/linalg/parallel.h>
#include <raybundle/solver/init/sightings.h>

#include <cstdint>
#include <span>

namespace raybundle::init {

/// Puts points that some of their sightings are far from where they agree better, by the poses of
/// the images that are marked: a wrong sighting that describes a point leads all others astray. Far
/// is twice what half of the points have no sighting beyond, and at least twice `threshold`, in
/// pixels. Returns how many moved.
std::int64_t move_to_agreement(const Sightings& sightings, std::span<const std::uint8_t> images,
                               std::span<const std::uint8_t> points, double threshold,
                               Problem& problem, linalg::ThreadPool& pool);

}  // namespace raybundle::init
