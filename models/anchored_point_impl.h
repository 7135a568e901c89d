// An anchored point, ready for its rows: the ray from centre P_i is D = G + s (P_m - P_i), and G
// with its derivatives is the same for all of them. With v = P_m - P_a, the direction w and the
// angle alpha between the two,
//   sigma = |v x w| = |v| sin(alpha),   delta = v . w = |v| cos(alpha),
//   k = |v| sin(alpha - theta) = sigma cos(theta) - delta sin(theta)      [Liu18, Eq. 2]
// and G = k w. Turning w by a small angle towards the unit vector q = (v - delta w) / sigma lowers
// alpha by as much, hence
//   dk/dtheta = -(sigma sin(theta) + delta cos(theta)),   dk = dk/dtheta (q . dw),
//   dk/dv     = cos(theta) q - sin(theta) w.
// Where v and w are parallel q is any; 0 is taken. Everything is derived in docs/parallax.md.

#pragma once

#include <raybundle/models/sensor_impl.h>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

struct AnchoredPoint {
  double G[3];
  double s;
  // The rest are derivatives.
  double s_first;       // of s, by the first unknown (inverse distance or theta)
  double G_leaf[3][3];  // of G, by each unknown
  double G_Pm[9];       // of G, by P_m; by P_a it is the negative
  double G_turn[9];     // of G, by a turn of the main anchor: dw = turn x w
  bool has_associate;
};

// The direction of the point in the world, and its derivatives by the two unknowns of a direction.
template <bool derivatives>
inline void direction(PointModel model, const CameraFrame& main, const double* stored, double* w,
                      double (*w_leaf)[3]) {
  if (model == PointModel::pba) {
    // Azimuth 0 along z, elevation towards y [Zhao15].
    const double sin_a = __builtin_sin(stored[0]), cos_a = __builtin_cos(stored[0]);
    const double sin_e = __builtin_sin(stored[1]), cos_e = __builtin_cos(stored[1]);
    w[0] = sin_a * cos_e;
    w[1] = sin_e;
    w[2] = cos_a * cos_e;
    if constexpr (derivatives) {
      const double azimuth[3] = {cos_a * cos_e, 0, -sin_a * cos_e};
      const double elevation[3] = {-sin_a * sin_e, cos_e, -cos_a * sin_e};
      for (int i = 0; i < 3; ++i) w_leaf[0][i] = azimuth[i], w_leaf[1][i] = elevation[i];
    }
    return;
  }
  row_times_matrix(stored, main.R_cw, w);  // R_wc n
  if constexpr (derivatives) {
    // n moves by (A delta) x n; a1 x n = -a2, a2 x n = a1  [Liu18, Eq. 3]
    double a1[3], a2[3];
    tangent_basis(stored, a1, a2);
    for (double& x : a2) x = -x;
    row_times_matrix(a2, main.R_cw, w_leaf[0]);
    row_times_matrix(a1, main.R_cw, w_leaf[1]);
  }
}

// G = w and s = the inverse distance.
template <bool derivatives>
inline void by_distance(double inverse_distance, const double* w, AnchoredPoint& point) {
  for (int i = 0; i < 3; ++i) point.G[i] = w[i];
  point.s = inverse_distance;
  if constexpr (derivatives) {
    point.s_first = 1;
    for (double& x : point.G_leaf[0]) x = 0;
    for (double& x : point.G_Pm) x = 0;
  }
}

// G = k w and s = sin(theta).
template <bool derivatives>
inline void by_parallax(double theta, const double* w, const double* P_m, const double* P_a,
                        AnchoredPoint& point, double* k, double* q) {
  double v[3], normal[3], rest[3];
  for (int i = 0; i < 3; ++i) v[i] = P_m[i] - P_a[i];
  cross(v, w, normal);
  const double sigma = __builtin_sqrt(dot(normal, normal));
  const double delta = dot(v, w);
  const double sine = __builtin_sin(theta), cosine = __builtin_cos(theta);
  *k = sigma * cosine - delta * sine;
  for (int i = 0; i < 3; ++i) point.G[i] = *k * w[i];
  point.s = sine;
  if constexpr (derivatives) {
    const double k_theta = -(sigma * sine + delta * cosine);
    cross(w, normal, rest);  // v - delta w, without cancellation
    const double inverse = sigma > 0 ? 1 / sigma : 0;
    for (int i = 0; i < 3; ++i) q[i] = rest[i] * inverse;
    point.s_first = cosine;
    for (int i = 0; i < 3; ++i) {
      point.G_leaf[0][i] = k_theta * w[i];
      for (int j = 0; j < 3; ++j) point.G_Pm[3 * i + j] = w[i] * (cosine * q[j] - sine * w[j]);
    }
    for (int i = 0; i < 3; ++i) q[i] *= k_theta;  // dk = q . dw from here on
  }
}

template <bool derivatives>
inline void prepare(const ResidualInput& in, Index index, AnchoredPoint& point) {
  const Anchors& anchors = in.anchors[index];
  const CameraFrame& main = in.cameras[anchors.main];
  const double* stored = in.points + index * stored_size(in.model);
  const double first = stored[stored_size(in.model) - 1];
  double w[3], w_leaf[2][3], k = 1, dk[3] = {0, 0, 0};
  direction<derivatives>(in.model, main, stored, w, w_leaf);
  point.has_associate = anchors.associate >= 0;
  if (point.has_associate) {
    by_parallax<derivatives>(first, w, main.P, in.cameras[anchors.associate].P, point, &k, dk);
  } else {
    by_distance<derivatives>(first, w, point);
  }
  if constexpr (derivatives) {
    for (int j = 0; j < 2; ++j) {
      const double along = dot(dk, w_leaf[j]);
      for (int i = 0; i < 3; ++i) point.G_leaf[1 + j][i] = along * w[i] + k * w_leaf[j][i];
    }
    // dw = turn x w: k -hat(w) turn, and dk . (turn x w) = turn . (w x dk). Of pba the direction is
    // the world's.
    double turn[3];
    cross(w, dk, turn);
    const double hat[9] = {0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const double value = w[i] * turn[j] - k * hat[3 * i + j];
        point.G_turn[3 * i + j] = in.model == PointModel::pba ? 0 : value;
      }
    }
  }
}

}  // namespace
}  // namespace raybundle::RAYBUNDLE_ISA
