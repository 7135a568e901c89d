// What the residual kernels share: the residual of a point in camera coordinates with its
// derivatives, and those by a pose. Included by the kernel units only.

#pragma once

#include <raybundle/models/bal_lens.h>
#include <raybundle/models/lanes_impl.h>
#include <raybundle/models/residual_kernels.h>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

using Index = std::int64_t;

// T is a number, or one in each lane of a vector.
template <class T>
[[gnu::always_inline]] inline T dot(const T* a, const T* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <class T>
[[gnu::always_inline]] inline void cross(const T* a, const T* b, T* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

// out = M a and out^T = a^T M for a 3x3 M, row-major.
template <class T>
[[gnu::always_inline]] inline void matrix_times(const T* M, const T* a, T* out) {
  for (int i = 0; i < 3; ++i) out[i] = dot(M + 3 * i, a);
}
template <class T>
[[gnu::always_inline]] inline void row_times_matrix(const T* a, const T* M, T* out) {
  for (int j = 0; j < 3; ++j) out[j] = a[0] * M[j] + a[1] * M[3 + j] + a[2] * M[6 + j];
}

// W of pixel_ray, row-major, for the observed ray v: a small difference d of rays is seen as pixels
// W d. The first two rows are the derivatives of the projection at v, which maps v itself to 0; the
// third is along v, second order at the solution, and tells a point behind the camera from one in
// front.
template <class T>
[[gnu::always_inline]] inline void pixels_of_ray(const T* lens, T aspect, const T* v, T* W) {
  T u[2], L[6];
  bal_lens::project(lens, v, u, W, L);
  const T f = lens[0] < 0.0 ? -lens[0] : lens[0];
  for (int k = 0; k < 3; ++k) {
    W[3 + k] *= aspect;
    W[6 + k] = f * v[k];
  }
}

// The residual r of X_c, A = dr/dX_c (rows of 3) and, for lenses, L = dr/d(f, k1, k2).
template <Sensor sensor, class T>
struct Measure {
  static constexpr int size = residual_size(sensor);
  static constexpr bool is_ray = size == 3;

  // The difference of the rays, [Liu18, Eq. 7] with the sign of u - observed, by their weight.
  [[gnu::always_inline]] static void weigh(const T* lens, T aspect, const T* direction,
                                           const T* observed, T* W, T* r) {
    if constexpr (sensor == Sensor::pixel_ray) {
      T difference[3];
      for (int i = 0; i < 3; ++i) difference[i] = direction[i] - observed[i];
      pixels_of_ray(lens, aspect, observed, W);
      matrix_times(W, difference, r);
    } else {
      *W = root(dot(observed, observed));
      for (int i = 0; i < 3; ++i) r[i] = *W * direction[i] - observed[i];
    }
  }

  [[gnu::always_inline]] static void residual(const T* lens, T aspect, const T* X_c,
                                              const T* observed, T* r) {
    if constexpr (is_ray) {
      const T inverse = 1.0 / root(dot(X_c, X_c));
      const T direction[3] = {X_c[0] * inverse, X_c[1] * inverse, X_c[2] * inverse};
      T W[9];
      weigh(lens, aspect, direction, observed, W, r);
    } else {
      bal_lens::project(lens, X_c, r);
      r[0] = r[0] - observed[0];
      r[1] = aspect * r[1] - observed[1];
    }
  }

  [[gnu::always_inline]] static void residual(const T* lens, T aspect, const T* X_c,
                                              const T* observed, T* r, T* A, T* L) {
    if constexpr (is_ray) {
      const T inverse = 1.0 / root(dot(X_c, X_c));
      const T direction[3] = {X_c[0] * inverse, X_c[1] * inverse, X_c[2] * inverse};
      T W[9];
      weigh(lens, aspect, direction, observed, W, r);
      // d(X/|X|) = (I - d d^T) / |X|, from the left W
      for (int i = 0; i < 3; ++i) {
        T row[3] = {};
        if constexpr (sensor == Sensor::pixel_ray) {
          for (int j = 0; j < 3; ++j) row[j] = W[3 * i + j];
        } else {
          row[i] = *W;
        }
        const T along = dot(row, direction);
        for (int j = 0; j < 3; ++j) A[3 * i + j] = (row[j] - along * direction[j]) * inverse;
      }
    } else {
      bal_lens::project(lens, X_c, r, A, L);
      r[0] = r[0] - observed[0];
      r[1] = aspect * r[1] - observed[1];
      for (int k = 3; k < 6; ++k) {
        A[k] *= aspect;
        L[k] *= aspect;
      }
    }
  }
};

template <int size, class T>
[[gnu::always_inline]] inline T squares(const T* r) {
  T sum = r[0] * r[0];
  for (int i = 1; i < size; ++i) sum += r[i] * r[i];
  return sum;
}

}  // namespace
}  // namespace raybundle::RAYBUNDLE_ISA
