#include <raybundle/models/point_model.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

using Eigen::Vector3d;
using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Map3 = Eigen::Map<const Vector3d>;

Eigen::Map<Vector3d> vector(double* x) { return Eigen::Map<Vector3d>(x); }

// Farther away a point is as good as at infinity: a pixel is more than 1e-6 of a radian.
constexpr double farthest = 1e12;

Vector3d to_world_axes(const double* R_cw, const Vector3d& x) {
  return Eigen::Map<const RowMajor>(R_cw).transpose() * x;
}

// G = k w and s of the ray; see models/anchored_point_impl.h for the same with derivatives.
struct Ray {
  Vector3d w;
  double k, s;
  double scale;  // of distances
};

Ray by_parallax(const Vector3d& w, double theta, const Vector3d& v) {
  const double k = v.cross(w).norm() * std::cos(theta) - v.dot(w) * std::sin(theta);
  return {w, k, std::sin(theta), v.norm()};
}

Ray ray_of(PointModel model, const double* stored, const AnchorPoses& anchors) {
  const double first = stored[stored_size(model) - 1];
  Vector3d w;
  if (model == PointModel::pba) {
    const double cos_e = std::cos(stored[1]);
    w = {std::sin(stored[0]) * cos_e, std::sin(stored[1]), std::cos(stored[0]) * cos_e};
  } else {
    w = to_world_axes(anchors.R_cw, Map3(stored));
  }
  if (anchors.P_associate == nullptr) return {w, 1, first, 1};
  return by_parallax(w, first, Map3(anchors.P) - Map3(anchors.P_associate));
}

void store_direction(PointModel model, const Vector3d& w, const double* R_cw, double* stored) {
  if (model == PointModel::pba) {
    stored[0] = std::atan2(w.x(), w.z());
    stored[1] = std::atan2(w.y(), std::hypot(w.x(), w.z()));
  } else {
    vector(stored) = (Eigen::Map<const RowMajor>(R_cw) * w).normalized();
  }
}

// A ray along the line through both anchors, without parallax, has neither G nor s: D would have no
// direction. A parallax that nobody can measure gives it one.
double usable_parallax(const Vector3d& w, double theta, const Vector3d& v) {
  constexpr double least = 1e-8;
  const Ray ray = by_parallax(w, theta, v);
  const double most = std::max(std::abs(ray.k), std::abs(ray.s) * ray.scale);
  return most > least * least * ray.scale ? theta : std::copysign(least, theta);
}

double angle(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

void to_world(PointModel model, const double* stored, const AnchorPoses& anchors, double* X) {
  if (model == PointModel::xyz) {
    std::copy_n(stored, 3, X);
    return;
  }
  const Ray ray = ray_of(model, stored, anchors);
  const double limit = farthest * ray.scale;
  const double distance = std::abs(ray.k) < limit * std::abs(ray.s)
                              ? ray.k / ray.s
                              : std::copysign(limit, ray.k) * (std::signbit(ray.s) ? -1 : 1);
  vector(X) = Map3(anchors.P) + distance * ray.w;
}

void from_world(PointModel model, const double* X, const AnchorPoses& anchors, PointSides sides,
                double* stored) {
  if (model == PointModel::xyz) {
    std::copy_n(X, 3, stored);
    return;
  }
  if (anchors.P_associate == nullptr) sides.main = sides.others;
  const Vector3d to_point = Map3(X) - Map3(anchors.P);
  const double distance = to_point.norm();
  Vector3d w =
      distance > 0 ? Vector3d(to_point / distance) : to_world_axes(anchors.R_cw, {0, 0, -1});
  w *= sides.main;
  double& first = stored[stored_size(model) - 1];
  store_direction(model, w, anchors.R_cw, stored);
  if (anchors.P_associate == nullptr) {
    first = sides.others / std::max(distance, 1 / farthest);
    return;
  }
  // Seen from the other side, D of Eq. 6 turns round, and with it the sense of the parallax.
  const Vector3d v = Map3(anchors.P) - Map3(anchors.P_associate);
  const double theta = angle(sides.main * to_point, sides.others * (to_point + v));
  first = usable_parallax(w, sides.others * theta, v);
}

void from_rays(PointModel model, const AnchorRays& rays, const AnchorPoses& anchors,
               double* stored) {
  const Vector3d w = to_world_axes(anchors.R_cw, Map3(rays.ray));
  double theta = 0, inverse_distance = 1;
  if (rays.ray_associate != nullptr) {
    const Vector3d v = Map3(anchors.P) - Map3(anchors.P_associate);
    theta = usable_parallax(
        w, angle(w, to_world_axes(rays.R_cw_associate, Map3(rays.ray_associate))), v);
    const Ray ray = by_parallax(w, theta, v);
    inverse_distance = std::clamp(ray.s / ray.k, -farthest / ray.scale, farthest / ray.scale);
  }
  switch (model) {
    case PointModel::xyz:
      vector(stored) = Map3(anchors.P) + w / inverse_distance;
      return;
    case PointModel::idp:
      store_direction(model, w, anchors.R_cw, stored);
      stored[3] = inverse_distance;
      return;
    case PointModel::pba:
    case PointModel::pmba:
      store_direction(model, w, anchors.R_cw, stored);
      stored[stored_size(model) - 1] = rays.ray_associate == nullptr ? inverse_distance : theta;
      return;
  }
}

void retract_point(PointModel model, const double* stored, const double* step, double* next) {
  switch (model) {
    case PointModel::xyz:
      for (int i = 0; i < 3; ++i) next[i] = stored[i] + step[i];
      return;
    case PointModel::pba:
      for (int i = 0; i < 3; ++i) next[i] = stored[i] + step[(i + 1) % 3];
      return;
    case PointModel::idp:
    case PointModel::pmba: {
      const Vector3d n = Map3(stored);
      Vector3d a1, a2;
      tangent_basis(n.data(), a1.data(), a2.data());
      const Vector3d turn = step[1] * a1 + step[2] * a2;
      const double size = turn.norm();
      next[3] = stored[3] + step[0];
      vector(next) = n;  // to the bit, where it does not turn
      if (size == 0) return;
      // Exp(turn) n, with turn perpendicular to n.
      vector(next) = (std::cos(size) * n + std::sin(size) / size * turn.cross(n)).normalized();
      return;
    }
  }
}

}  // namespace raybundle
