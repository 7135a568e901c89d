#pragma once

#include <raybundle/models/point_model.h>
#include <raybundle/models/problem.h>

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace raybundle {

/// The observations of one point, in order of their cameras: rows first .. last - 1 of the arrays
/// below.
struct Track {
  std::int64_t first, last;
};

/// Rays seen along tracks, and the cameras that saw them.
struct SeenRays {
  const std::int32_t* camera;  ///< per row
  const double* ray;           ///< per row: 3, in the camera's frame
  const double* R_cw;          ///< per camera: 9, row-major
  const double* centre;        ///< per camera: 3
};

/// Rotations and centres of the cameras of a problem or state.
class CameraPoses {
 public:
  explicit CameraPoses(const std::vector<double>& cameras);

  const double* R_cw(std::int32_t camera) const { return R_cw_.data() + 9 * std::int64_t{camera}; }
  const double* P(std::int32_t camera) const { return P_.data() + 3 * std::int64_t{camera}; }
  AnchorPoses of(const Anchors& anchors) const;
  /// What these cameras saw along `rays`; row_camera and rays outlive it.
  SeenRays seen(std::span<const std::int32_t> row_camera, std::span<const double> rays) const;

 private:
  std::vector<double> R_cw_, P_;
};

/// The anchors of a point, and the rows in which they see it.
struct AnchorRows {
  Anchors anchors;
  std::int64_t main_row = -1;
  std::int64_t associate_row = -1;
};

/// How good a pair of rays of the world is to describe a point by: acute angles, the larger the
/// better, then the others. From -2 to 1.
double anchor_quality(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// Of so long a track no more observers are compared.
inline constexpr std::int64_t most_compared_anchors = 32;

/// The pair of observers whose rays have the largest angle below a right one [Zhao15, Liu18, 2.1],
/// of which the earlier camera is the main anchor; angles above a right one count only where there
/// is no other. Cameras at the same place make no pair. Of long tracks 32 observers, evenly spaced,
/// are compared. `first_is_main`: the pair contains the first observer, as idp has it.
AnchorRows choose_anchors(const SeenRays& seen, Track track, bool first_is_main);

}  // namespace raybundle
