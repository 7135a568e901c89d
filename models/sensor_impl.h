// What the residual kernels share: the residual of a point in camera coordinates with its
// derivatives, and those by a pose. Included by the kernel units only.

#pragma once

#include <raybundle/models/bal_lens.h>
#include <raybundle/models/residual_kernels.h>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

using Index = std::int64_t;

inline double dot(const double* a, const double* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline void cross(const double* a, const double* b, double* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

// out = M a and out^T = a^T M for a 3x3 M, row-major.
inline void matrix_times(const double* M, const double* a, double* out) {
  for (int i = 0; i < 3; ++i) out[i] = dot(M + 3 * i, a);
}
inline void row_times_matrix(const double* a, const double* M, double* out) {
  for (int j = 0; j < 3; ++j) out[j] = a[0] * M[j] + a[1] * M[3 + j] + a[2] * M[6 + j];
}

// The residual r of X_c, A = dr/dX_c (rows of 3) and, for lenses, L = dr/d(f, k1, k2).
template <Sensor sensor>
struct Measure {
  static constexpr int size = residual_size(sensor);

  static void residual(const CameraFrame& camera, const double* X_c, const double* observed,
                       double* r) {
    if constexpr (sensor == Sensor::ray) {
      // [Liu18, Eq. 7] with the sign of u - observed
      const double scale = __builtin_sqrt(dot(observed, observed) / dot(X_c, X_c));
      for (int i = 0; i < 3; ++i) r[i] = scale * X_c[i] - observed[i];
    } else {
      bal_lens::project(camera.lens, X_c, r);
      r[0] -= observed[0];
      r[1] = camera.aspect * r[1] - observed[1];
    }
  }

  static void residual(const CameraFrame& camera, const double* X_c, const double* observed,
                       double* r, double* A, double* L) {
    if constexpr (sensor == Sensor::ray) {
      // d(X/|X|) = (I - d d^T) / |X|
      const double inverse = 1 / __builtin_sqrt(dot(X_c, X_c));
      const double weight = __builtin_sqrt(dot(observed, observed));
      const double scale = weight * inverse;
      for (int i = 0; i < 3; ++i) {
        const double d_i = X_c[i] * inverse;
        r[i] = weight * d_i - observed[i];
        for (int j = 0; j < 3; ++j) A[3 * i + j] = -scale * d_i * X_c[j] * inverse;
        A[3 * i + i] += scale;
      }
    } else {
      bal_lens::project(camera.lens, X_c, r, A, L);
      r[0] -= observed[0];
      r[1] = camera.aspect * r[1] - observed[1];
      for (int k = 3; k < 6; ++k) {
        A[k] *= camera.aspect;
        L[k] *= camera.aspect;
      }
    }
  }
};

inline double squares(const double* r, int size) {
  double sum = 0;
  for (int i = 0; i < size; ++i) sum += r[i] * r[i];
  return sum;
}

}  // namespace
}  // namespace raybundle::RAYBUNDLE_ISA
