#pragma once

#include <raybundle/linalg/parallel.h>

#include <cstdint>
#include <vector>

namespace raybundle {

/// A bundle adjustment problem: cameras, points and where the cameras saw the points.
/// Plain contiguous arrays, in the order of the input; nothing here is ever reordered.
///
/// A camera has nine parameters, in BAL order: rotation vector (3, radians) and translation (3) of
/// the map from world to camera, X_c = R_cw X + t_cw, then focal length f (pixels) and the radial
/// distortion k1, k2 (no unit). A camera looks down its -z axis.
struct Problem {
  static constexpr int camera_size = 9;  ///< parameters of a camera
  static constexpr int point_size = 3;   ///< parameters of a point

  std::vector<double> cameras;  ///< camera_size per camera
  std::vector<double> points;   ///< point_size per point, world frame

  std::vector<std::int32_t> observation_camera;  ///< per observation: index of the camera
  std::vector<std::int32_t> observation_point;   ///< per observation: index of the point
  std::vector<double> observations;              ///< x, y per observation, pixels from the centre

  /// f_y / f_x of all cameras: y of an observation, and of its residual, is in pixels that are 1 /
  /// aspect times as high as wide.
  double aspect = 1;

  /// Bit k set: parameter k of that camera stays as it is. Empty: all cameras are free.
  std::vector<std::uint16_t> fixed_camera_parameters;
  /// Non-zero: that point stays where it is. Empty: all points are free.
  std::vector<std::uint8_t> fixed_points;

  std::int64_t camera_count() const {
    return static_cast<std::int64_t>(cameras.size()) / camera_size;
  }
  std::int64_t point_count() const { return static_cast<std::int64_t>(points.size()) / point_size; }
  std::int64_t observation_count() const {
    return static_cast<std::int64_t>(observation_camera.size());
  }
};

/// Throws InputError when array sizes disagree, an index is out of range, a number is not finite or
/// there is no camera, no point or no observation. Cameras and points nobody observes are legal.
void validate(const Problem& problem);
void validate(const Problem& problem, linalg::ThreadPool& pool);  ///< the same, in parallel
void validate_sizes(const Problem& problem);                      ///< of the arrays alone

}  // namespace raybundle
