// Rows of anchored points: each touches the camera that observes and the point, and feels the
// anchors through the point. The derivatives by a pose are formed as those by its centre P and by a
// small turn of its axes in the world, R_wc <- Exp(turn) R_wc, and then carried over to the
// unknowns of the pose update.

#pragma once

#include <raybundle/models/anchored_point_impl.h>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

// From the derivatives by centre and turn to those by the step of a pose (models/pose.h):
//   local   turn = -dphi,      dP = P x dphi - dt
//   global  turn = -J_r dphi,  dP = P x J_r dphi - R_wc dt
//   se3     turn = -R_wc dphi, dP = -R_wc dt
template <PoseUpdate Update>
inline void pose_row(const CameraFrame& camera, const double* by_centre, const double* by_turn,
                     double* J) {
  if constexpr (Update == PoseUpdate::se3) {
    matrix_times(camera.R_cw, by_turn, J);
    matrix_times(camera.R_cw, by_centre, J + 3);
    for (int i = 0; i < 6; ++i) J[i] = -J[i];
  } else {
    double turn[3];
    cross(by_centre, camera.P, turn);
    for (int i = 0; i < 3; ++i) turn[i] -= by_turn[i];
    if constexpr (Update == PoseUpdate::local) {
      for (int i = 0; i < 3; ++i) J[i] = turn[i];
      for (int i = 0; i < 3; ++i) J[3 + i] = -by_centre[i];
    } else {
      row_times_matrix(turn, camera.J_r, J);
      matrix_times(camera.R_cw, by_centre, J + 3);
      for (int i = 3; i < 6; ++i) J[i] = -J[i];
    }
  }
}

template <Sensor sensor>
struct AnchoredRows {
  static constexpr int R = residual_size(sensor);
  static constexpr int hub_size = camera_unknowns(sensor);

  // D, the ray from the observer in the world, and the same in its frame.
  static void ray(const AnchoredPoint& point, const CameraFrame& main, const CameraFrame& observer,
                  double* D, double* X_c) {
    const bool own = &main == &observer;
    for (int i = 0; i < 3; ++i) {
      D[i] = own ? point.w[i] : point.G[i] + point.s * (main.P[i] - observer.P[i]);
    }
    matrix_times(observer.R_cw, D, X_c);
  }

  // Calls visit(row, point) for rows [first, last).
  template <class Visit>
  static void for_rows(const ResidualInput& in, Index first, Index last, Visit&& visit) {
    for (Index row = first; row < last;) {
      const std::int32_t at = in.row_point[row];
      AnchoredPoint point;
      prepare<false>(in, at, point, nullptr);
      for (; row < last && in.row_point[row] == at; ++row) visit(row, point);
    }
  }

  static void residual_of(const ResidualInput& in, Index row, const AnchoredPoint& point,
                          double* residual) {
    const CameraFrame& observer = in.cameras[in.row_camera[row]];
    double D[3], X_c[3];
    ray(point, in.cameras[in.anchors[in.row_point[row]].main], observer, D, X_c);
    Measure<sensor, double>::residual(observer.lens, observer.aspect, X_c, in.observed + R * row, residual);
  }

  static double cost(const ResidualInput& in, Index first, Index last) {
    double sum = 0;
    for_rows(in, first, last, [&](Index row, const AnchoredPoint& point) {
      double r[R];
      residual_of(in, row, point, r);
      sum += squares<R>(r);
    });
    return 0.5 * sum;
  }

  static void residuals(const ResidualInput& in, double* residual, Index first, Index last) {
    for_rows(in, first, last, [&](Index row, const AnchoredPoint& point) {
      residual_of(in, row, point, residual + R * (row - first));
    });
  }

  // The derivatives of one residual by the point, with b its gradient by D.
  static void leaf_row(const AnchoredPoint& point, const double* b, const double* offset,
                       double* J) {
    for (int k = 0; k < 3; ++k) J[k] = dot(b, point.G_leaf[k]);
    J[0] += point.s_first * dot(b, offset);
  }
  static void own_leaf_row(const AnchoredPoint& point, const double* b, double* J) {
    J[0] = 0;
    for (int k = 0; k < 2; ++k) J[1 + k] = dot(b, point.w_leaf[k]);
  }

  template <PoseUpdate Update>
  static void linearize_row(const ResidualInput& in, const ResidualOutput& out, Index row,
                            const CameraFrame& main, const AnchoredPoint& point) {
    const CameraFrame& observer = in.cameras[in.row_camera[row]];
    const bool own = &main == &observer;
    const double s = own ? point.inverse_distance : point.s;
    double D[3], X_c[3], A[3 * R], L[6], offset[3];
    ray(point, main, observer, D, X_c);
    Measure<sensor, double>::residual(observer.lens, observer.aspect, X_c, in.observed + R * row, out.residual + R * row, A, L);
    for (int i = 0; i < 3; ++i) offset[i] = main.P[i] - observer.P[i];
    for (int i = 0; i < R; ++i) {
      double b[3], by_centre[3], by_turn[3];
      double* J_leaf = out.J_leaf + (R * row + i) * 3;
      row_times_matrix(A + 3 * i, observer.R_cw, b);
      if (own) {
        own_leaf_row(point, b, J_leaf);
      } else {
        leaf_row(point, b, offset, J_leaf);
      }
      for (int k = 0; k < 3; ++k) by_centre[k] = -s * b[k];
      cross(b, D, by_turn);
      double* J = out.J_hub + (R * row + i) * hub_size;
      pose_row<Update>(observer, by_centre, by_turn, J);
      if constexpr (sensor == Sensor::pixel_and_lens) {
        for (int k = 0; k < 3; ++k) J[6 + k] = L[3 * i + k];
      }
    }
  }

  template <PoseUpdate Update>
  static void write_effect(const CameraFrame& camera, const AnchorEffect& effect, double* Z) {
    for (int i = 0; i < 3; ++i) {
      pose_row<Update>(camera, effect.by_centre[i], effect.by_turn[i], Z + i * hub_size);
      for (int k = 6; k < hub_size; ++k) Z[i * hub_size + k] = 0;
    }
  }

  template <PoseUpdate Update>
  static double linearize(const ResidualInput& in, const ResidualOutput& out, Index first,
                          Index last) {
    double sum = 0;
    for (Index row = first; row < last;) {
      const std::int32_t at = in.row_point[row];
      const Anchors& anchors = in.anchors[at];
      AnchoredPoint point;
      AnchorEffect effect[2];
      prepare<true>(in, at, point, effect);
      if (row == 0 || in.row_point[row - 1] != at) {
        double* Z = out.Z + in.first_anchor[at] * 3 * hub_size;
        write_effect<Update>(in.cameras[anchors.main], effect[0], Z);
        if (anchors.associate >= 0) {
          write_effect<Update>(in.cameras[anchors.associate], effect[1], Z + 3 * hub_size);
        }
      }
      for (; row < last && in.row_point[row] == at; ++row) {
        linearize_row<Update>(in, out, row, in.cameras[anchors.main], point);
        sum += squares<R>(out.residual + R * row);
      }
    }
    return 0.5 * sum;
  }
};

}  // namespace
}  // namespace raybundle::RAYBUNDLE_ISA
