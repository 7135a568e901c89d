#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <vector>

namespace raybundle::init {

/// A ray in the world, and how many pixels a radian is for it.
struct WorldRay {
  Eigen::Vector3d centre, direction;
  double pixels;
};

struct TriangulationOptions {
  double threshold = 4;        ///< pixels: the largest error of a ray that is used
  double min_parallax = 0.02;  ///< radians, between some two of the rays used
};

struct Triangulated {
  Eigen::Vector3d X;
  std::vector<std::uint8_t> used;  ///< of a ray
};

/// The point with the least sum of squared angles to rays, in front of all that are used; where not
/// all agree, to those that agree with the point of two of them which most agree with. Empty where
/// fewer than two are left, or without the parallax.
std::optional<Triangulated> triangulated(const std::vector<WorldRay>& rays,
                                         const TriangulationOptions& options);

/// Of `start` and the points that pairs of these rays make that with which they agree best: the
/// least sum of log(1 + (pixels_off / scale)^2). `start` itself where all are within two scales.
Eigen::Vector3d best_agreed(const std::vector<WorldRay>& rays, const Eigen::Vector3d& start,
                            double scale);

/// The angle between a ray and the direction of X, in pixels; large behind.
double pixels_off(const WorldRay& ray, const Eigen::Vector3d& X);

}  // namespace raybundle::init
