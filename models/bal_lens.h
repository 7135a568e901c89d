#pragma once

/// The BAL lens: p = -X_c.xy / X_c.z, u = f (1 + k1 |p|^2 + k2 |p|^4) p  [Qu18, Eq. 3.6, 3.7], for
/// a point or for one in each lane of a vector. Plain arithmetic that is always inlined, so that a
/// unit compiled for an instruction set gets its own copy.
namespace raybundle::bal_lens {

/// Pixel of a point in camera coordinates.
template <class T>
[[gnu::always_inline]] inline void project(const T* lens, const T* X_c, T* u) {
  const T inverse_z = -1.0 / X_c[2];
  const T px = X_c[0] * inverse_z;
  const T py = X_c[1] * inverse_z;
  const T n = px * px + py * py;
  const T scale = lens[0] * (1.0 + n * (lens[1] + n * lens[2]));
  u[0] = scale * px;
  u[1] = scale * py;
}

/// Pixel, its derivatives A by X_c (2x3) and L by f, k1, k2 (2x3), row-major
/// [Qu18, Eq. 3.10-3.16].
template <class T>
[[gnu::always_inline]] inline void project(const T* lens, const T* X_c, T* u, T* A, T* L) {
  const T f = lens[0];
  const T inverse_z = -1.0 / X_c[2];
  const T p[2] = {X_c[0] * inverse_z, X_c[1] * inverse_z};
  const T n = p[0] * p[0] + p[1] * p[1];
  const T distortion = 1.0 + n * (lens[1] + n * lens[2]);
  // du/dp = f (distortion I + 2 (k1 + 2 k2 |p|^2) p p^T), the compact form of (3.13)-(3.15).
  const T radial = 2.0 * f * (lens[1] + 2.0 * n * lens[2]);
  const T cross = radial * p[0] * p[1];
  const T D[4] = {f * distortion + radial * p[0] * p[0], cross, cross,
                  f * distortion + radial * p[1] * p[1]};
  for (int i = 0; i < 2; ++i) {
    u[i] = f * distortion * p[i];
    // dp/dX_c = -1/z [1 0 p.x; 0 1 p.y].
    A[3 * i] = D[2 * i] * inverse_z;
    A[3 * i + 1] = D[2 * i + 1] * inverse_z;
    A[3 * i + 2] = A[3 * i] * p[0] + A[3 * i + 1] * p[1];
    L[3 * i] = distortion * p[i];
    L[3 * i + 1] = f * n * p[i];
    L[3 * i + 2] = n * L[3 * i + 1];
  }
}

}  // namespace raybundle::bal_lens
