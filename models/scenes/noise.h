#pragma once

#include <raybundle/models/scenes/scene.h>

#include <cstdint>
#include <vector>

/// What makes a Scene a problem to solve: errors of the observations, then a start away from the
/// truth. Each has its own seed, so that one can change while the other stays.
namespace raybundle::scenes {

/// [Qu18, 5.1.3]
struct NoiseOptions {
  std::uint64_t seed = 1;
  double pixel_noise = 1;    ///< standard deviation of each coordinate, pixels
  double outlier_share = 0;  ///< of the observations, 0 to 1: uniform in the image instead
};

struct NoisyProblem {
  Problem problem;                     ///< true cameras and points, noisy observations
  std::vector<std::int64_t> outliers;  ///< indices of observations, ascending
};

/// Throws InputError for noise that is negative or not finite, or a share outside 0 to 1.
NoisyProblem add_noise(const Scene& scene, const NoiseOptions& options = {});

/// How far the start is from the truth [Qu18, 5.1.4]: normal deviations, none of them in units of
/// the scene.
struct StartOptions {
  std::uint64_t seed = 1;
  double rotation = 0.002;  ///< of each component of the rotation vectors, radians
  double position = 0.004;  ///< of each coordinate of the camera centres, relative to the depth of
                            ///< what it sees (1 / root mean square of 1 / depth)
  double focal = 0.01;      ///< of the focal lengths, relative; at most 0.25
  bool distortion = false;  ///< k1 and k2 start as they are; else at 0, being close to it
  double point = 0.004;     ///< of each coordinate of the points, relative to their depth in the
                            ///< nearest camera that sees them
};

/// The same observations from perturbed cameras and points. Throws InputError for deviations that
/// are negative or not finite.
Problem perturb(const Problem& truth, const StartOptions& options = {});

}  // namespace raybundle::scenes
