#pragma once

#include <raybundle/models/problem.h>

#include <array>
#include <optional>
#include <vector>

namespace raybundle {

/// The undistorted projection p of a pixel u = f (1 + k1 |p|^2 + k2 |p|^4) p, for a lens of f, k1,
/// k2 and square pixels. Empty where the lens makes no such pixel before it folds back, and where f
/// is 0.
std::optional<std::array<double, 2>> undistort(const double* lens, const double* u);

/// The direction xi([p.x, p.y, -1]) from which each observation was seen, in the camera's frame: 3
/// numbers per observation, by the lenses of the problem. Throws InputError for an observation that
/// its camera's lens cannot have made.
std::vector<double> observed_rays(const Problem& problem);

/// observed_rays(), but for such an observation as if its camera had no distortion.
std::vector<double> apparent_rays(const Problem& problem);

}  // namespace raybundle
