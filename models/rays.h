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

/// The problem as lenses of the same f without distortion would have seen it: an observation
/// becomes f p, k1 and k2 become 0. Residuals change by the distortion's local scale. Throws
/// InputError for an observation that its camera's lens cannot have made.
Problem undistorted(Problem problem);

/// The problem as cameras of one focal length, the upper median of those that observe
/// something, would have seen it: the
/// pixels of each, which are f times something that f does not change, are scaled, and with them
/// its residuals. Throws InputError for a camera with f = 0 that observes something.
Problem with_one_focal_length(Problem problem);

}  // namespace raybundle
