// An anchored point, ready for its rows: the ray from centre P_i is D = G + s (P_m - P_i), and G
// with its derivatives is the same for all of them. With v = P_m - P_a, the direction w and the
// angle alpha between the two,
//   sigma = |v x w| = |v| sin(alpha),   delta = v . w = |v| cos(alpha),
//   k = |v| sin(alpha - theta) = sigma cos(theta) - delta sin(theta)      [Liu18, Eq. 2]
// and G = k w. The main anchor itself sees w, with any factor: k may pass through 0 and below, and
// its D would turn round there. Turning w by a small angle towards the unit vector
// q = (v - delta w) / sigma lowers alpha by as much, hence
//   dk/dtheta = -(sigma sin(theta) + delta cos(theta)),   dk = dk/dtheta (q . dw).
// Where v and w are parallel q is any; 0 is taken.
//
// A step of an anchor moves the point as some step (dfirst, dw) of the point alone would: a turn of
// the main anchor's axes turns w, and a move of either centre counts at right angles to its ray,
// over the distance of the point. Everything is derived in docs/parallax.md.

#pragma once

#include <raybundle/models/row_vectors_impl.h>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

// The point as a camera sees it: what the rows of one point share, in the order that rows in lanes
// load it.
struct alignas(64) SeenPoint {
  double G[3];
  double s;
  double P_m[3];
  // The rest are derivatives.
  double s_first;       // of s, by the first unknown (inverse distance or theta)
  double G_leaf[3][3];  // of G, by each unknown
};

// As all but its main anchor see it, and as that one does: G = w and D = w, since P_m - P_i is 0
// there; s is what its derivatives by the centre want, the inverse distance.
struct AnchoredPoint {
  SeenPoint others, main;
};

// The step of a point that is worth a step of an anchor: by centre and by turn (Exp(turn) R_wc) of
// the anchor, for each unknown.
struct AnchorEffect {
  double by_centre[3][3];
  double by_turn[3][3];
};

// The direction of the point in the world, and its derivatives by the two unknowns of a direction,
// at right angles to one another.
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

// v = P_m - P_a and what follows from it; see above.
struct Parallax {
  double k, sine, cosine, sigma, delta, baseline;
  double q[3];

  Parallax(double theta, const double* w, const double* P_m, const double* P_a) {
    double v[3], normal[3];
    for (int i = 0; i < 3; ++i) v[i] = P_m[i] - P_a[i];
    cross(v, w, normal);
    sigma = __builtin_sqrt(dot(normal, normal));
    delta = dot(v, w);
    baseline = __builtin_sqrt(dot(v, v));
    sine = __builtin_sin(theta);
    cosine = __builtin_cos(theta);
    k = sigma * cosine - delta * sine;
    cross(w, normal, q);  // v - delta w, without cancellation
    const double inverse = sigma > 0 ? 1 / sigma : 0;
    for (double& x : q) x *= inverse;
  }
  double k_theta() const { return -(sigma * sine + delta * cosine); }
};

// a / b for a b that may vanish, then with `least` for it.
inline double bounded_ratio(double a, double b, double least) {
  if (b > least || b < -least) return a / b;
  return least > 0 ? (b < 0 ? -a : a) / least : 0;
}

// The step dw = along of a direction, in its two unknowns: by the rows of `along`, 3 x 3.
inline void by_direction(const double (*w_leaf)[3], const double* along, double (*out)[3]) {
  for (int j = 0; j < 2; ++j) {
    // Only the azimuth of pba has another length than 1, and none at the poles.
    const double scale = bounded_ratio(1, dot(w_leaf[j], w_leaf[j]), 1e-14);
    row_times_matrix(w_leaf[j], along, out[1 + j]);
    for (int i = 0; i < 3; ++i) out[1 + j][i] *= scale;
  }
}

// dw = turn x w and dw = inverse_distance (I - w w^T) dP of the main anchor.
inline void main_effect(PointModel model, const double* w, const double (*w_leaf)[3],
                        double inverse_distance, AnchorEffect& main) {
  double across[9];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      across[3 * i + j] = inverse_distance * ((i == j ? 1.0 : 0.0) - w[i] * w[j]);
    }
  }
  by_direction(w_leaf, across, main.by_centre);
  if (model == PointModel::pba) {  // its direction is the world's
    for (auto& row : main.by_turn) row[0] = row[1] = row[2] = 0;
    return;
  }
  const double hat[9] = {0, w[2], -w[1], -w[2], 0, w[0], w[1], -w[0], 0};
  by_direction(w_leaf, hat, main.by_turn);
  for (double& x : main.by_turn[0]) x = 0;
}

template <bool derivatives>
inline void prepare(const ResidualInput& in, Index index, AnchoredPoint& point,
                    AnchorEffect* effect) {
  const Anchors& anchors = in.anchors[index];
  const CameraFrame& main = in.cameras[anchors.main];
  const double* stored = in.points + index * stored_size(in.model);
  const double first = stored[stored_size(in.model) - 1];
  double* w = point.main.G;
  double(*w_leaf)[3] = point.main.G_leaf + 1;
  point.main.s = 0;
  for (int i = 0; i < 3; ++i) point.main.P_m[i] = point.others.P_m[i] = main.P[i];
  if constexpr (derivatives) {
    point.main.s_first = 0;
    for (double& x : point.main.G_leaf[0]) x = 0;
  }
  SeenPoint& others = point.others;
  direction<derivatives>(in.model, main, stored, w, w_leaf);
  if (anchors.associate < 0) {  // G = w and s = the inverse distance
    for (int i = 0; i < 3; ++i) others.G[i] = w[i];
    others.s = first;
    if constexpr (derivatives) {
      others.s_first = 1;
      point.main.s = first;
      for (int i = 0; i < 3; ++i) {
        others.G_leaf[0][i] = 0;
        for (int j = 0; j < 2; ++j) others.G_leaf[1 + j][i] = w_leaf[j][i];
      }
      main_effect(in.model, w, w_leaf, first, effect[0]);
      for (int i = 0; i < 3; ++i) effect[0].by_centre[0][i] = -first * first * w[i];
    }
    return;
  }
  const Parallax at(first, w, main.P, in.cameras[anchors.associate].P);
  for (int i = 0; i < 3; ++i) others.G[i] = at.k * w[i];
  others.s = at.sine;
  if constexpr (derivatives) {
    const double k_theta = at.k_theta();
    others.s_first = at.cosine;
    for (int i = 0; i < 3; ++i) others.G_leaf[0][i] = k_theta * w[i];
    for (int j = 0; j < 2; ++j) {
      const double along = k_theta * dot(at.q, w_leaf[j]);
      for (int i = 0; i < 3; ++i) others.G_leaf[1 + j][i] = along * w[i] + at.k * w_leaf[j][i];
    }
    // In the very centre of an anchor: as if a small part of the baseline away.
    const double least = 1e-7 * at.baseline;
    const double to_main = bounded_ratio(at.sine, at.k, least);
    point.main.s = to_main;
    const double to_associate = bounded_ratio(at.sine, at.sigma, least);
    main_effect(in.model, w, w_leaf, to_main, effect[0]);
    effect[1] = {};
    for (int i = 0; i < 3; ++i) {
      effect[0].by_centre[0][i] = -to_main * at.q[i];
      effect[1].by_centre[0][i] = to_associate * (at.cosine * at.q[i] - at.sine * w[i]);
    }
  }
}

}  // namespace
}  // namespace raybundle::RAYBUNDLE_ISA
