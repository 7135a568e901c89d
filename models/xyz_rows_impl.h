// Rows of points given by their coordinates: each touches the camera that observes, and the point.

#pragma once

#include <raybundle/models/row_vectors_impl.h>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

struct NoPoints {};  // those of the state are all that is needed

template <Sensor of>
struct ObservedXyz {
  static constexpr Sensor sensor = of;
  static constexpr int R = residual_size(sensor);

  CameraLanes camera;
  Lanes X[3], X_c[3], observed[R];

  template <bool derivatives, bool with_J_r>
  [[gnu::always_inline]] void load(const ResidualInput& in, NoPoints /*points*/, Index /*place*/,
                                   Index row) {
    load_cameras<with_J_r, false>(in.cameras, in.row_camera + row, camera);
    const double* points[lanes];
    for (int i = 0; i < lanes; ++i) points[i] = in.points + 3 * Index{in.row_point[row + i]};
    load_columns<3>(points, X);
    load_rows<R>(in.observed + R * row, observed);
    // X_c = R_cw X + t_cw  [Qu18, Eq. 3.5]
    matrix_times(camera.R_cw(), X, X_c);
    for (int i = 0; i < 3; ++i) X_c[i] += camera.t_cw()[i];
  }

  template <PoseUpdate Update>
  [[gnu::always_inline]] void derive(const Lanes* a, Lanes* J_leaf, Lanes* J_pose) const {
    row_times_matrix(a, camera.R_cw(), J_leaf);  // [Qu18, Eq. 3.37]
    const Lanes* by_translation = a;
    if constexpr (Update == PoseUpdate::local) {
      // -R hat(X) and R  [Qu18, Eq. 4.19, 4.16]
      cross(X, J_leaf, J_pose);
      by_translation = J_leaf;
    } else if constexpr (Update == PoseUpdate::global) {
      // -R hat(X) J_r and I  [Qu18, Eq. 3.27, 3.18]
      Lanes w[3];
      cross(X, J_leaf, w);
      row_times_matrix(w, camera.J_r, J_pose);
    } else {
      // d(Exp(phi) X_c + t) at 0: -hat(X_c) and I
      cross(X_c, a, J_pose);
    }
    for (int i = 0; i < 3; ++i) J_pose[3 + i] = by_translation[i];
  }
};

template <Sensor sensor>
struct XyzRows {
  using Observed = ObservedXyz<sensor>;

  static double cost(const ResidualInput& in, Index first, Index last) {
    return in_vectors<sensor>(in, first, last, [](const auto& rows, Index begin, Index end) {
      return vectors_cost<Observed>(rows, NoPoints{}, begin, end);
    });
  }

  static void residuals(const ResidualInput& in, double* residual, Index first, Index last) {
    const ResidualOutput out = {residual - Observed::R * first, nullptr, nullptr, nullptr};
    in_vectors<sensor>(in, out, first, last,
                       [](const auto& rows, const auto& to, Index begin, Index end) {
                         return vectors_residuals<Observed>(rows, NoPoints{}, to, begin, end);
                       });
  }

  template <PoseUpdate Update>
  static double linearize(const ResidualInput& in, const ResidualOutput& out, Index first,
                          Index last) {
    return in_vectors<sensor>(
        in, out, first, last, [](const auto& rows, const auto& to, Index begin, Index end) {
          return vectors_linearize<Observed, Update>(rows, NoPoints{}, to, begin, end);
        });
  }
};

}  // namespace
}  // namespace raybundle::RAYBUNDLE_ISA
