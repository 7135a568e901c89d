#pragma once

#include <cstdint>

namespace raybundle {

/// How a point is described, by three unknowns:
///   xyz   its coordinates in the world
///   idp   direction and inverse distance, seen from the first camera that observes it
///   pba   elevation and azimuth in the world, from the main anchor, and the parallax angle between
///         main and associate anchor [Zhao15]
///   pmba  direction in the frame of the main anchor, and parallax angle   [Liu18, Eq. 1-4]
/// Of the anchored ones (all but xyz) the ray from a camera with centre P_i is, up to scale,
///   D = G + s (P_m - P_i)                                                 [Liu18, Eq. 6]
/// (the main anchor sees w itself, whichever sign the distance has: docs/parallax.md),
/// where the distance from the main anchor's centre P_m along the direction w is |G| / s:
///   idp        G = w,                                  s = inverse distance
///   pba, pmba  G = sin(alpha - theta) |P_m - P_a| w,   s = sin(theta)
/// It has a meaning at any distance, infinity and beyond (behind the camera) included. A point that
/// one camera alone observes has no parallax: pba and pmba describe its distance as idp does.
enum class PointModel { xyz, idp, pba, pmba };

constexpr bool is_anchored(PointModel model) { return model != PointModel::xyz; }

/// Numbers that hold a point: X (3); n (3) and inverse distance; azimuth, elevation, theta; n (3)
/// and theta. Angles are in radians; n has length 1.
constexpr int stored_size(PointModel model) {
  return model == PointModel::idp || model == PointModel::pmba ? 4 : 3;
}

/// The cameras that a point is described from.
struct Anchors {
  std::int32_t main = -1;
  std::int32_t associate = -1;  ///< -1: none, as for idp, or where one camera observes the point
};

/// Two unit vectors a1, a2 with [a1 a2 n] a rotation, for a unit vector n; smooth but for n.z = 0
/// [Duff17].
[[gnu::always_inline]] inline void tangent_basis(const double* n, double* a1, double* a2) {
  const double sign = n[2] < 0 ? -1.0 : 1.0;
  const double a = -1 / (sign + n[2]);
  const double b = n[0] * n[1] * a;
  a1[0] = 1 + sign * n[0] * n[0] * a;
  a1[1] = sign * b;
  a1[2] = -sign * n[0];
  a2[0] = b;
  a2[1] = sign + n[1] * n[1] * a;
  a2[2] = -n[1];
}

/// Where a point's anchors stand; what an unused associate has may be null.
struct AnchorPoses {
  const double* R_cw;  ///< of the main anchor
  const double* P;     ///< of the main anchor
  const double* P_associate;
};

/// The world coordinates. A point at infinity, or nearly, is put at 1e12 times the distance of the
/// anchors (1e12 without associate), where the difference cannot be seen.
void to_world(PointModel model, const double* stored, const AnchorPoses& anchors, double* X);

/// On which side, 1 in front and -1 behind, the main anchor and the other observers of a point saw
/// it. Behind all of them it is beyond infinity.
struct PointSides {
  double main = 1;
  double others = 1;
};

/// Stored numbers of the point X, seen from these sides; in the anchor's centre it has any
/// direction. Where both are described by one number, the main anchor's side is the others'.
void from_world(PointModel model, const double* X, const AnchorPoses& anchors, PointSides sides,
                double* stored);
/// Stored numbers of a point seen from its anchors along `ray` and `ray_associate` (unit vectors in
/// the cameras' frames, the latter null where there is none) [Liu18, Remark 5]: parallax and
/// direction come from rotations and rays alone, and of the centres only idp needs the distance.
struct AnchorRays {
  const double* ray;
  const double* ray_associate;
  const double* R_cw_associate;
};
void from_rays(PointModel model, const AnchorRays& rays, const AnchorPoses& anchors,
               double* stored);

/// next = stored moved by the step (3 numbers: inverse distance or theta, then the direction)
/// [Liu18, Eq. 3, 4]; for xyz their sum. `next` may be `stored`.
void retract_point(PointModel model, const double* stored, const double* step, double* next);

}  // namespace raybundle
