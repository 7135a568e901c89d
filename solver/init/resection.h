#pragma once

#include <raybundle/models/random.h>
#include <raybundle/solver/init/p3p.h>
#include <raybundle/solver/init/ransac.h>
#include <raybundle/solver/init/sightings.h>

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace raybundle::init {

/// Points of known place and the unit rays along which one image saw them, in columns.
struct SeenPoints {
  Eigen::Matrix3Xd X;      ///< in the world
  Eigen::Matrix3Xd rays;   ///< in the camera's frame
  Eigen::VectorXd pixels;  ///< per radian, at each ray

  std::int64_t size() const { return X.cols(); }
};

/// What an image saw of the points that are marked, where the problem has them.
SeenPoints seen_points(const Sightings& sightings, std::int32_t image,
                       std::span<const std::uint8_t> points, const Problem& problem);

struct ResectionOptions {
  double threshold = 8;           ///< pixels: the largest error of an inlier
  std::int64_t min_inliers = 12;  ///< else the image has no pose
  RansacOptions ransac = {};
};

struct Resection {
  CameraPose pose;
  std::vector<std::int32_t> inliers;  ///< ascending
};

/// The pose of an image from points it saw: three-point samples in RANSAC, refined on the inliers.
/// Empty where there are too few of them.
std::optional<Resection> resection(const SeenPoints& seen, const ResectionOptions& options,
                                   Random& random);

}  // namespace raybundle::init
