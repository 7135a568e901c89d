// A pair of rays (a, b) fits a pose where e = b . (t x R a) = b^T E a is 0: both are in one plane
// with the baseline. Turning a by a small angle changes e by at most the part of E^T b at right
// angles to a, of which the square is |E^T b|^2 - e^2; likewise b. In pixels, to first order,
//   d^2 = e^2 / ((|E^T b|^2 - e^2) / p_a^2 + (|E a|^2 - e^2) / p_b^2)              [Sampson82]
// with p pixels per radian.

#include <raybundle/solver/init/epipolar.h>

#include <raybundle/models/point_model.h>
#include <raybundle/models/rotation.h>
#include <raybundle/solver/init/small_descent.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <cmath>
#include <limits>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Step = Eigen::Matrix<double, 5, 1>;

double squared(double x) { return x * x; }

RelativePose moved(const RelativePose& pose, const Step& step) {
  Vector3d across, along;
  tangent_basis(pose.t.data(), across.data(), along.data());
  return {so3::exp(step.head<3>()) * pose.R,
          (pose.t + step[3] * across + step[4] * along).normalized()};
}

double cost(const RelativePose& pose, const RayPairs& pairs, std::span<const std::int32_t> which,
            double scale) {
  const Matrix3d E = essential_matrix(pose);
  double sum = 0;
  for (const std::int32_t i : which) {
    sum += std::log1p(squared_epipolar_error(E, pairs, i) / squared(scale));
  }
  return sum;
}

// J^T W J and J^T W r of r = e / sqrt(variance), the latter held fixed, with Cauchy's weights.
struct Normal {
  Eigen::Matrix<double, 5, 5> H = Eigen::Matrix<double, 5, 5>::Zero();
  Step g = Step::Zero();
};

Normal normal_equations(const RelativePose& pose, const RayPairs& pairs,
                        std::span<const std::int32_t> which, double scale) {
  Normal result;
  const Matrix3d E = essential_matrix(pose);
  Vector3d across, along;
  tangent_basis(pose.t.data(), across.data(), along.data());
  for (const std::int32_t i : which) {
    const RayPair pair = pairs.pair(i);
    const Vector3d &b = pair.b, Ra = pose.R * pair.a;
    const EpipolarError error = epipolar_error(E, pair);
    if (!(error.variance > 0)) continue;
    const double weight = 1 / (error.variance * (1 + error.squared() / squared(scale)));
    const Vector3d by_t = Ra.cross(b);
    Step J;
    J << Ra.cross(b.cross(pose.t)), by_t.dot(across), by_t.dot(along);
    result.H += weight * J * J.transpose();
    result.g += weight * error.e * J;
  }
  return result;
}

}  // namespace

Matrix3d essential_matrix(const RelativePose& pose) { return so3::hat(pose.t) * pose.R; }

std::array<RelativePose, 4> poses_of(const Matrix3d& E) {
  const Eigen::JacobiSVD<Matrix3d> svd(E, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d U = svd.matrixU(), V = svd.matrixV();
  if (U.determinant() < 0) U.col(2) *= -1;
  if (V.determinant() < 0) V.col(2) *= -1;
  Matrix3d W;
  W << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Matrix3d one = U * W * V.transpose(), other = U * W.transpose() * V.transpose();
  const Vector3d t = U.col(2);
  return {{{one, t}, {one, -t}, {other, t}, {other, -t}}};
}

double EpipolarError::squared() const {
  if (variance > 0) return e * e / variance;
  return e == 0 ? 0 : std::numeric_limits<double>::infinity();
}

EpipolarError epipolar_error(const Matrix3d& E, const RayPair& pair) {
  const Vector3d Ea = E * pair.a, Eb = E.transpose() * pair.b;
  const double e = pair.b.dot(Ea);
  return {e, std::max(Eb.squaredNorm() - e * e, 0.0) / squared(pair.pixels_a) +
                 std::max(Ea.squaredNorm() - e * e, 0.0) / squared(pair.pixels_b)};
}

double squared_epipolar_error(const Matrix3d& E, const RayPairs& pairs, std::int64_t i) {
  return epipolar_error(E, pairs.pair(i)).squared();
}

// l_b b = l_a R a + t: crossed with b and with R a it tells the signs of both distances.
Side side_of(const RelativePose& pose, const RayPair& pair, double least_parallax) {
  const Vector3d a = pose.R * pair.a;
  const Vector3d normal = pair.b.cross(a);
  const double pixels = std::min(pair.pixels_a, pair.pixels_b);
  if (a.dot(pair.b) > 0 && normal.norm() * pixels < least_parallax) return Side::far;
  const double l_a = pose.t.cross(pair.b).dot(normal), l_b = pose.t.cross(a).dot(normal);
  return l_a > 0 && l_b > 0 ? Side::front : Side::behind;
}

Sides sides(const RelativePose& pose, const RayPairs& pairs, std::span<const std::int32_t> which,
            double least_parallax) {
  Sides result;
  for (const std::int32_t i : which) {
    const Side side = side_of(pose, pairs.pair(i), least_parallax);
    result.front += side == Side::front ? 1 : 0;
    result.behind += side == Side::behind ? 1 : 0;
  }
  return result;
}

RelativePose facing_pose(const Matrix3d& E, const RayPairs& pairs,
                         std::span<const std::int32_t> which, double least_parallax) {
  RelativePose best;
  std::int64_t most = -1;
  for (const RelativePose& pose : poses_of(E)) {
    const std::int64_t front = sides(pose, pairs, which, least_parallax).front;
    if (front > most) most = front, best = pose;
  }
  return best;
}

RelativePose refined_pose(const RelativePose& start, const RayPairs& pairs,
                          std::span<const std::int32_t> which, double scale) {
  const auto cost_of = [&](const RelativePose& pose) { return cost(pose, pairs, which, scale); };
  return small_descent(start, cost_of, [&](const RelativePose& pose, double damping) {
    Normal normal = normal_equations(pose, pairs, which, scale);
    normal.H.diagonal() *= 1 + damping;
    normal.H.diagonal().array() += 1e-12 * normal.H.trace();
    return moved(pose, normal.H.ldlt().solve(-normal.g));
  });
}

}  // namespace raybundle::init
