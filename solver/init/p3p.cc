// s_1, s_2, s_3 are the distances of the points, a, b, c the sides of their triangle opposite of
// points 1, 2, 3, and cos_a, cos_b, cos_c those of the angles between the rays of the other two.
// With u = s_2 / s_1 and v = s_3 / s_1, the three laws of cosines leave a quartic for v, and u
// follows [Haralick94, Eq. 8, 9].

#include <raybundle/solver/init/p3p.h>

#include <raybundle/solver/init/real_eigen.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <array>
#include <cmath>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using Quartic = std::array<double, 5>;  // of v^0 .. v^4

struct Triangle {
  double a2, b2, c2, cos_a, cos_b, cos_c;
};

Quartic quartic(const Triangle& t) {
  const double p = (t.a2 - t.c2) / t.b2, q = (t.a2 + t.c2) / t.b2;
  const double c_b = t.c2 / t.b2, a_b = t.a2 / t.b2;
  const double aa = t.cos_a * t.cos_a, bb = t.cos_b * t.cos_b, cc = t.cos_c * t.cos_c;
  const double ac = t.cos_a * t.cos_c;
  return {(1 + p) * (1 + p) - 4 * a_b * cc,
          4 * (-p * (1 + p) * t.cos_b + 2 * a_b * cc * t.cos_b - (1 - q) * ac),
          2 * (p * p - 1 + 2 * p * p * bb + 2 * (1 - c_b) * aa - 4 * q * ac * t.cos_b +
               2 * (1 - a_b) * cc),
          4 * (p * (1 - p) * t.cos_b - (1 - q) * ac + 2 * c_b * aa * t.cos_b),
          (p - 1) * (p - 1) - 4 * c_b * aa};
}

// Real positive roots, by the eigenvalues of the companion matrix and a few of Newton's steps:
// double roots come out as pairs with small imaginary parts.
std::vector<double> positive_roots(const Quartic& A) {
  std::vector<double> result;
  if (!(std::abs(A[4]) > 0)) return result;
  SmallSquare companion = SmallSquare::Zero(4, 4);
  for (int i = 0; i < 4; ++i) companion(i, 3) = -A[static_cast<std::size_t>(i)] / A[4];
  for (int i = 0; i < 3; ++i) companion(i + 1, i) = 1;
  for (const RealEigen& eigen : real_eigen(companion, 1e-4)) {
    if (!(eigen.value > 0)) continue;
    double v = eigen.value;
    for (int step = 0; step < 3; ++step) {
      const double value = A[0] + v * (A[1] + v * (A[2] + v * (A[3] + v * A[4])));
      const double slope = A[1] + v * (2 * A[2] + v * (3 * A[3] + v * 4 * A[4]));
      if (slope != 0 && std::isfinite(value / slope)) v -= value / slope;
    }
    if (v > 0) result.push_back(v);
  }
  return result;
}

// Three axes at right angles, by two sides of a triangle.
Matrix3d axes(const Matrix3d& X) {
  const Vector3d first = (X.col(1) - X.col(0)).normalized();
  const Vector3d third = first.cross(X.col(2) - X.col(0)).normalized();
  Matrix3d result;
  result << first, third.cross(first), third;
  return result;
}

}  // namespace

std::vector<CameraPose> poses_of_three(const Matrix3d& X, const Matrix3d& rays) {
  const Triangle t = {(X.col(1) - X.col(2)).squaredNorm(), (X.col(0) - X.col(2)).squaredNorm(),
                      (X.col(0) - X.col(1)).squaredNorm(), rays.col(1).dot(rays.col(2)),
                      rays.col(0).dot(rays.col(2)),        rays.col(0).dot(rays.col(1))};
  std::vector<CameraPose> result;
  const double area = (X.col(1) - X.col(0)).cross(X.col(2) - X.col(0)).norm();
  if (!(area > 1e-12 * (t.a2 + t.b2 + t.c2))) return result;
  const double p = (t.a2 - t.c2) / t.b2;
  for (const double v : positive_roots(quartic(t))) {
    const double u =
        ((p - 1) * v * v - 2 * p * t.cos_b * v + 1 + p) / (2 * (t.cos_c - v * t.cos_a));
    const double s1 = std::sqrt(t.b2 / (1 + v * v - 2 * v * t.cos_b));
    if (!(u > 0) || !std::isfinite(u * s1)) continue;
    Matrix3d X_c;
    X_c << s1 * rays.col(0), u * s1 * rays.col(1), v * s1 * rays.col(2);
    CameraPose pose;
    pose.R_cw = axes(X_c) * axes(X).transpose();
    pose.t_cw = (X_c - pose.R_cw * X).rowwise().mean();
    if (pose.R_cw.allFinite() && pose.t_cw.allFinite()) result.push_back(pose);
  }
  return result;
}

}  // namespace raybundle::init
