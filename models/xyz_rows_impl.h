// Rows of points given by their coordinates: each touches the camera that observes, and the point.

#pragma once

#include <raybundle/models/row_range_impl.h>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

template <Sensor sensor>
struct XyzRows {
  static constexpr int R = residual_size(sensor);

  // What the rows in the lanes are about.
  struct Observed {
    CameraLanes camera;
    Lanes X[3], X_c[3], observed[R];

    template <bool with_J_r>
    [[gnu::always_inline]] void load(const ResidualInput& in, Index row) {
      load_cameras<with_J_r, false>(in.cameras, in.row_camera + row, camera);
      const double* points[lanes];
      for (int i = 0; i < lanes; ++i) points[i] = in.points + 3 * Index{in.row_point[row + i]};
      load_columns<3>(points, X);
      load_rows<R>(in.observed + R * row, observed);
      // X_c = R_cw X + t_cw  [Qu18, Eq. 3.5]
      matrix_times(camera.R_cw(), X, X_c);
      for (int i = 0; i < 3; ++i) X_c[i] += camera.t_cw()[i];
    }
    template <class... Derivatives>
    [[gnu::always_inline]] void residual(Lanes* r, Derivatives... A_and_L) const {
      Measure<sensor, Lanes>::residual(camera.lens(), camera.aspect(), X_c, observed, r,
                                       A_and_L...);
    }
  };

  // Rows before `first` are read (vector_at).
  static double vectors_cost(const ResidualInput& in, Index first, Index last) {
    Lanes total = {};
    for (Index row = first; row < last; row += lanes) {
      const Index begin = vector_at(row, last);
      Observed at;
      Lanes r[R];
      at.template load<false>(in, begin);
      at.residual(r);
      total += from_lane(row - begin, squares<R>(r));
    }
    return 0.5 * sum(total);
  }

  static double cost(const ResidualInput& in, Index first, Index last) {
    if (last - first >= lanes) return vectors_cost(in, first, last);
    const ShortRange<sensor> range(in, first, last);
    return vectors_cost(range.input(in), range.begin(), lanes);
  }

  // Rows before `first` are written too.
  static void vectors_residuals(const ResidualInput& in, double* residual, Index first,
                                Index last) {
    for (Index row = first; row < last; row += lanes) {
      const Index begin = vector_at(row, last);
      Observed at;
      Lanes r[R];
      at.template load<false>(in, begin);
      at.residual(r);
      store_rows<R>(r, residual + R * begin);
    }
  }

  static void residuals(const ResidualInput& in, double* residual, Index first, Index last) {
    if (last - first >= lanes) return vectors_residuals(in, residual - R * first, first, last);
    ShortRange<sensor> range(in, first, last);
    vectors_residuals(range.input(in), range.residual, range.begin(), lanes);
    range.copy_residual(residual);
  }

  // The derivative of one residual by the pose, with a = its gradient by X_c and b = by the point.
  template <PoseUpdate Update>
  [[gnu::always_inline]] static void pose_row(const Observed& at, const Lanes* a, const Lanes* b,
                                              Lanes* J) {
    if constexpr (Update == PoseUpdate::local) {
      // -R hat(X) and R  [Qu18, Eq. 4.19, 4.16]
      cross(at.X, b, J);
      for (int i = 0; i < 3; ++i) J[3 + i] = b[i];
    } else if constexpr (Update == PoseUpdate::global) {
      // -R hat(X) J_r and I  [Qu18, Eq. 3.27, 3.18]
      Lanes w[3];
      cross(at.X, b, w);
      row_times_matrix(w, at.camera.J_r, J);
      for (int i = 0; i < 3; ++i) J[3 + i] = a[i];
    } else {
      // d(Exp(phi) X_c + t) at 0: -hat(X_c) and I
      cross(at.X_c, a, J);
      for (int i = 0; i < 3; ++i) J[3 + i] = a[i];
    }
  }

  template <PoseUpdate Update>
  static double vectors_linearize(const ResidualInput& in, const ResidualOutput& out, Index first,
                                  Index last) {
    constexpr int hub_size = camera_unknowns(sensor);
    Lanes total = {};
    for (Index row = first; row < last; row += lanes) {
      const Index begin = vector_at(row, last);
      Observed at;
      Lanes r[R], A[3 * R], L[6], J_leaf[3 * R], J_hub[R * hub_size];
      at.template load<Update == PoseUpdate::global>(in, begin);
      at.residual(r, A, L);
      total += from_lane(row - begin, squares<R>(r));
      for (int i = 0; i < R; ++i) {
        row_times_matrix(A + 3 * i, at.camera.R_cw(), J_leaf + 3 * i);  // [Qu18, Eq. 3.37]
        pose_row<Update>(at, A + 3 * i, J_leaf + 3 * i, J_hub + hub_size * i);
        if constexpr (sensor == Sensor::pixel_and_lens) {
          for (int k = 0; k < 3; ++k) J_hub[hub_size * i + 6 + k] = L[3 * i + k];
        }
      }
      store_rows<R>(r, out.residual + R * begin);
      store_rows<3 * R>(J_leaf, out.J_leaf + 3 * R * begin);
      store_rows<R * hub_size>(J_hub, out.J_hub + R * hub_size * begin);
    }
    return 0.5 * sum(total);
  }

  template <PoseUpdate Update>
  static double linearize(const ResidualInput& in, const ResidualOutput& out, Index first,
                          Index last) {
    if (last - first >= lanes) return vectors_linearize<Update>(in, out, first, last);
    ShortRange<sensor> range(in, first, last);
    const double total =
        vectors_linearize<Update>(range.input(in), range.output(), range.begin(), lanes);
    range.copy(out, first);
    return total;
  }
};

}  // namespace
}  // namespace raybundle::RAYBUNDLE_ISA
