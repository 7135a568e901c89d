#pragma once

#include <raybundle/models/formulation.h>

#include <cstdint>

/// Residuals of observations and their derivatives, over ranges of rows; compiled once per
/// instruction set and chosen when the program starts.
namespace raybundle {

/// A camera as the kernels want it: what all of them read fills two lines of the cache.
struct alignas(64) CameraFrame {
  double R_cw[9];  ///< row-major
  double t_cw[3];
  double lens[3];  ///< f, k1, k2
  double aspect;   ///< f_y / f_x
  double J_r[9];   ///< right Jacobian of the rotation vector; used by PoseUpdate::global
  double P[3];     ///< the centre; used by anchored points
};

/// What one row range reads. Row r is the observation of point row_point[r] by camera
/// row_camera[r]; observed holds a pixel (2) or a ray (3) per row.
struct ResidualInput {
  const CameraFrame* cameras;
  const double* points;  ///< stored_size(model) numbers each
  const std::int32_t* row_camera;
  const std::int32_t* row_point;
  const double* observed;
  PointModel model;
  const Anchors* anchors;  ///< per point; null for xyz
  const std::int64_t*
      first_anchor;  ///< per point: place of its main anchor's block in Z, then that
                     ///< of its associate; null for xyz
};

/// What linearisation writes: row by row the residual (2 or 3 numbers), J_hub (9 columns: rotation,
/// translation, lens, or 6 without lens) and J_leaf (3 columns), and of points whose first row is
/// in the range Z: what a step of an anchor is worth in steps of the point (3 x 9 or 3 x 6 each).
struct ResidualOutput {
  double* residual;
  double* J_hub;
  double* J_leaf;
  double* Z;
};

/// Over rows [first, last).
struct ResidualKernels {
  /// 1/2 sum |r|^2.
  double (*cost)(const ResidualInput& in, std::int64_t first, std::int64_t last);
  /// The residuals; that of row `first` goes to residual[0].
  void (*residuals)(const ResidualInput& in, double* residual, std::int64_t first,
                    std::int64_t last);
  /// The cost, and all of ResidualOutput.
  double (*linearize)(const ResidualInput& in, const ResidualOutput& out, std::int64_t first,
                      std::int64_t last);
};

/// What differs between kernels. Rays leave the lenses as they are: `ray` has the length of an
/// observed ray for its weight, `pixel_ray` is weighted by the pixels per radian of its lens.
enum class Sensor { pixel_and_lens, pixel, ray, pixel_ray };
inline constexpr int sensors = 4;
constexpr int residual_size(Sensor sensor) {
  return sensor == Sensor::ray || sensor == Sensor::pixel_ray ? 3 : 2;
}
constexpr int camera_unknowns(Sensor sensor) { return sensor == Sensor::pixel_and_lens ? 9 : 6; }
/// Throws std::invalid_argument for rays and free lenses.
Sensor sensor_of(const Formulation& formulation);

/// The kernels of one instruction set, by the values of Sensor and PoseUpdate.
struct KernelsBySensor {
  ResidualKernels of[sensors];
};
struct KernelsByUpdate {
  KernelsBySensor of[3];
};

const ResidualKernels& residual_kernels(bool anchored, PoseUpdate update, Sensor sensor);

}  // namespace raybundle
