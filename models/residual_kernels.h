#pragma once

#include <raybundle/models/lens.h>
#include <raybundle/models/pose.h>

#include <cstdint>

/// Residuals of observations and their derivatives, over ranges of rows; compiled once per
/// instruction set and chosen when the program starts.
namespace raybundle {

/// A camera as the kernels want it.
struct CameraFrame {
  double R_cw[9];  ///< row-major
  double t_cw[3];
  double lens[3];  ///< f, k1, k2
  double J_r[9];   ///< right Jacobian of the rotation vector; used by PoseUpdate::global
};

/// What one row range reads. Row r is the observation of point row_point[r] by camera
/// row_camera[r]; observed holds two pixels per row.
struct ResidualInput {
  const CameraFrame* cameras;
  const double* points;
  const std::int32_t* row_camera;
  const std::int32_t* row_point;
  const double* observed;
};

/// What linearisation writes, row by row: residual (2), J_hub (2x9 or 2x6: rotation, translation,
/// lens) and J_leaf (2x3).
struct ResidualOutput {
  double* residual;
  double* J_hub;
  double* J_leaf;
};

/// Over rows [first, last).
struct ResidualKernels {
  /// 1/2 sum |u - observed|^2.
  double (*cost)(const ResidualInput& in, std::int64_t first, std::int64_t last);
  /// u - observed, two numbers per row; that of row `first` goes to residual[0].
  void (*residuals)(const ResidualInput& in, double* residual, std::int64_t first,
                    std::int64_t last);
  /// The cost, and all of ResidualOutput.
  double (*linearize)(const ResidualInput& in, const ResidualOutput& out, std::int64_t first,
                      std::int64_t last);
};

const ResidualKernels& residual_kernels(PoseUpdate update, Lens lens);

}  // namespace raybundle
