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

// W of pixel_ray, row-major, for the observed ray v: a small difference d of rays is seen as pixels
// W d. The first two rows are the derivatives of the projection at v, which maps v itself to 0; the
// third is along v, second order at the solution, and tells a point behind the camera from one in
// front.
inline void pixels_of_ray(const CameraFrame& camera, const double* v, double* W) {
  double u[2], L[6];
  bal_lens::project(camera.lens, v, u, W, L);
  const double f = camera.lens[0] < 0 ? -camera.lens[0] : camera.lens[0];
  for (int k = 0; k < 3; ++k) {
    W[3 + k] *= camera.aspect;
    W[6 + k] = f * v[k];
  }
}

// The residual r of X_c, A = dr/dX_c (rows of 3) and, for lenses, L = dr/d(f, k1, k2).
template <Sensor sensor>
struct Measure {
  static constexpr int size = residual_size(sensor);
  static constexpr bool is_ray = size == 3;

  // The difference of the rays, [Liu18, Eq. 7] with the sign of u - observed, by their weight.
  static void weigh(const CameraFrame& camera, const double* direction, const double* observed,
                    double* W, double* r) {
    double difference[3];
    if constexpr (sensor == Sensor::pixel_ray) {
      for (int i = 0; i < 3; ++i) difference[i] = direction[i] - observed[i];
      pixels_of_ray(camera, observed, W);
      matrix_times(W, difference, r);
    } else {
      *W = __builtin_sqrt(dot(observed, observed));
      for (int i = 0; i < 3; ++i) r[i] = *W * direction[i] - observed[i];
    }
  }

  static void residual(const CameraFrame& camera, const double* X_c, const double* observed,
                       double* r) {
    if constexpr (is_ray) {
      const double inverse = 1 / __builtin_sqrt(dot(X_c, X_c));
      const double direction[3] = {X_c[0] * inverse, X_c[1] * inverse, X_c[2] * inverse};
      double W[9];
      weigh(camera, direction, observed, W, r);
    } else {
      bal_lens::project(camera.lens, X_c, r);
      r[0] -= observed[0];
      r[1] = camera.aspect * r[1] - observed[1];
    }
  }

  static void residual(const CameraFrame& camera, const double* X_c, const double* observed,
                       double* r, double* A, double* L) {
    if constexpr (is_ray) {
      const double inverse = 1 / __builtin_sqrt(dot(X_c, X_c));
      const double direction[3] = {X_c[0] * inverse, X_c[1] * inverse, X_c[2] * inverse};
      double W[9];
      weigh(camera, direction, observed, W, r);
      // d(X/|X|) = (I - d d^T) / |X|, from the left W
      for (int i = 0; i < 3; ++i) {
        double row[3] = {0, 0, 0};
        if constexpr (sensor == Sensor::pixel_ray) {
          for (int j = 0; j < 3; ++j) row[j] = W[3 * i + j];
        } else {
          row[i] = *W;
        }
        const double along = dot(row, direction);
        for (int j = 0; j < 3; ++j) A[3 * i + j] = (row[j] - along * direction[j]) * inverse;
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
