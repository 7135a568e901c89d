// Rows of points given by their coordinates: each touches the camera that observes, and the point.

#pragma once

#include <raybundle/models/sensor_impl.h>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

template <Sensor sensor>
struct XyzRows {
  static constexpr int R = residual_size(sensor);

  // X_c = R_cw X + t_cw  [Qu18, Eq. 3.5].
  static void to_camera(const CameraFrame& camera, const double* X, double* X_c) {
    for (int i = 0; i < 3; ++i) {
      const double* R_i = camera.R_cw + 3 * i;
      X_c[i] = R_i[0] * X[0] + R_i[1] * X[1] + R_i[2] * X[2] + camera.t_cw[i];
    }
  }

  static void residual_of(const ResidualInput& in, Index row, double* residual) {
    const CameraFrame& camera = in.cameras[in.row_camera[row]];
    double X_c[3];
    to_camera(camera, in.points + 3 * Index{in.row_point[row]}, X_c);
    Measure<sensor>::residual(camera, X_c, in.observed + R * row, residual);
  }

  static double cost(const ResidualInput& in, Index first, Index last) {
    double sum = 0;
    for (Index row = first; row < last; ++row) {
      double r[R];
      residual_of(in, row, r);
      sum += squares(r, R);
    }
    return 0.5 * sum;
  }

  static void residuals(const ResidualInput& in, double* residual, Index first, Index last) {
    for (Index row = first; row < last; ++row) residual_of(in, row, residual + R * (row - first));
  }

  // The derivative of one residual by the pose, with a = its gradient by X_c and b = by the point.
  template <PoseUpdate Update>
  static void pose_row(const CameraFrame& camera, const double* X, const double* X_c,
                       const double* a, const double* b, double* J) {
    if constexpr (Update == PoseUpdate::local) {
      // -R hat(X) and R  [Qu18, Eq. 4.19, 4.16]
      cross(X, b, J);
      for (int i = 0; i < 3; ++i) J[3 + i] = b[i];
    } else if constexpr (Update == PoseUpdate::global) {
      // -R hat(X) J_r and I  [Qu18, Eq. 3.27, 3.18]
      double w[3];
      cross(X, b, w);
      row_times_matrix(w, camera.J_r, J);
      for (int i = 0; i < 3; ++i) J[3 + i] = a[i];
    } else {
      // d(Exp(phi) X_c + t) at 0: -hat(X_c) and I
      cross(X_c, a, J);
      for (int i = 0; i < 3; ++i) J[3 + i] = a[i];
    }
  }

  template <PoseUpdate Update>
  static double linearize(const ResidualInput& in, const ResidualOutput& out, Index first,
                          Index last) {
    constexpr int hub_size = camera_unknowns(sensor);
    double sum = 0;
    for (Index row = first; row < last; ++row) {
      const CameraFrame& camera = in.cameras[in.row_camera[row]];
      const double* X = in.points + 3 * Index{in.row_point[row]};
      double X_c[3], A[3 * R], L[6];
      const Index at = row - first;
      double* residual = out.residual + R * at;
      to_camera(camera, X, X_c);
      Measure<sensor>::residual(camera, X_c, in.observed + R * row, residual, A, L);
      sum += squares(residual, R);
      for (int i = 0; i < R; ++i) {
        double* J_leaf = out.J_leaf + (R * at + i) * 3;
        double* J_hub = out.J_hub + (R * at + i) * hub_size;
        row_times_matrix(A + 3 * i, camera.R_cw, J_leaf);  // [Qu18, Eq. 3.37]
        pose_row<Update>(camera, X, X_c, A + 3 * i, J_leaf, J_hub);
        if constexpr (sensor == Sensor::pixel_and_lens) {
          for (int k = 0; k < 3; ++k) J_hub[6 + k] = L[3 * i + k];
        }
      }
    }
    return 0.5 * sum;
  }
};

}  // namespace
}  // namespace raybundle::RAYBUNDLE_ISA
