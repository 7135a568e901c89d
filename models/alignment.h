#pragma once

#include <raybundle/models/problem.h>

#include <cstdint>
#include <vector>

#include <Eigen/Core>

/// How far an estimate is from the truth, where only the shape can be compared: a reconstruction
/// from images has neither place, nor direction, nor size.
namespace raybundle {

/// x -> scale R x + t
struct Similarity {
  double scale = 1;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator()(const Eigen::Vector3d& x) const { return scale * (R * x) + t; }
};

/// The similarity that minimises sum |to_i - S(from_i)|^2, in closed form [Umeyama91, Eq. 40-43];
/// never a reflection. Three coordinates per point. Where the points determine it in part only, the
/// rest is chosen: of collinear points any best turn about their line; where either set is a single
/// place, or empty, or the two have nothing in common, no turn and no change of size. Throws
/// InputError when the sizes differ or are no multiple of 3.
Similarity align(const std::vector<double>& from, const std::vector<double>& to);

/// |to_i - S(from_i)| for each point.
std::vector<double> distances(const Similarity& S, const std::vector<double>& from,
                              const std::vector<double>& to);

/// Root of the mean square; 0 of nothing.
double root_mean_square(const std::vector<double>& values);

/// Rotations R_cw of the cameras.
std::vector<Eigen::Matrix3d> camera_rotations(const Problem& problem);

/// Camera centres P = -R_cw^T t_cw, three coordinates per camera.
std::vector<double> camera_centres(const Problem& problem);

/// Errors after alignment, in the units of the truth. Cameras and points that nobody observes are
/// left out.
struct TruthErrors {
  std::int64_t cameras = 0;  ///< that were compared
  std::int64_t points = 0;
  double camera_rmse = 0;  ///< of the camera centres, also called ATE
  double point_rmse = 0;   ///< of the points, after an alignment of their own
  /// Median distance of the points after the alignment of the cameras: a few points far off, which
  /// settle size and value of point_rmse, do not change it.
  double point_median = 0;
  double point_rmse_by_cameras = 0;  ///< the other two pairings of figure and alignment
  double point_median_own = 0;
  double rotation_mean = 0;  ///< of the angles between the cameras' directions, degrees
  Similarity camera_alignment;
  Similarity point_alignment;
  std::vector<double> camera_errors;  ///< per camera of the problem; NaN where left out
  /// Per point of the problem, after the alignment of the cameras; NaN where left out. Empty where
  /// the truth has no points.
  std::vector<double> point_errors;
};

/// Compares camera centres and points with those of `truth`, each after an alignment of their own,
/// as [Qu18, 5.3.2] does, and orientations after the one turn of the world that fits them best:
/// centres on a line leave a turn open. What `truth` observes does not matter; where it has no
/// points cameras alone are compared, and the members about points stay as they are above. Throws
/// InputError when the numbers of cameras or points differ.
TruthErrors compare_with_truth(const Problem& problem, const Problem& truth);

}  // namespace raybundle
