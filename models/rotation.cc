// Rotations through unit quaternions: half-angle forms have no cancellation near 0 or near pi, and
// atan2 gives the angle with full accuracy everywhere. Formulas: [Qu18, Eq. 2.6, 3.24-3.26],
// [Sola17].

#include <raybundle/models/rotation.h>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <cmath>

namespace raybundle::so3 {
namespace {

double norm(const Vector3& v) { return std::hypot(v.x(), v.y(), v.z()); }

/// sin(x) / x
double sinc(double x) { return x == 0 ? 1.0 : std::sin(x) / x; }

/// (1 - cos x) / x^2, written with the half angle so that nothing cancels.
double cosine_deficit(double x) {
  const double s = sinc(0.5 * x);
  return 0.5 * s * s;
}

/// (x - sin x) / x^3 for x >= 0. Below 1 by its series: nine terms leave a relative error under
/// 1e-17 there, and from 1 on the closed form loses less than three bits.
double sine_deficit(double x) {
  if (x >= 1) return (x - std::sin(x)) / (x * x * x);
  const double x2 = x * x;
  double sum = 0;
  for (int k = 8; k >= 1; --k) sum = x2 / ((2 * k + 2) * (2 * k + 3)) * (1 - sum);
  return (1 - sum) / 6;
}

/// hat(phi)^2 = phi phi^T - |phi|^2 I
Matrix3 hat_squared(const Vector3& phi) {
  Matrix3 result = phi * phi.transpose();
  result.diagonal().array() -= phi.squaredNorm();
  return result;
}

/// The rotation matrix of a quaternion; dividing by |q|^2 keeps it orthonormal to rounding.
Matrix3 matrix(const Quaternion& q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double s = 2 / q.squaredNorm();
  Matrix3 R;
  R << 1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y),  //
      s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x),   //
      s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y);
  return R;
}

/// The quaternion of a rotation matrix, up to a positive factor close to 1. Its largest component
/// comes from the diagonal and divides the others, so nothing is divided by a small number.
Quaternion extract_quaternion(const Matrix3& R) {
  const double trace = R.trace();
  Eigen::Index k = 0;
  const double largest = R.diagonal().maxCoeff(&k);
  if (trace >= largest) {
    const double w4 = 2 * std::sqrt(1 + trace);  // 4 w
    return {0.25 * w4, (R(2, 1) - R(1, 2)) / w4, (R(0, 2) - R(2, 0)) / w4,
            (R(1, 0) - R(0, 1)) / w4};
  }
  const Eigen::Index i = (k + 1) % 3;
  const Eigen::Index j = (k + 2) % 3;
  const double v4 = 2 * std::sqrt(1 + R(k, k) - R(i, i) - R(j, j));  // 4 times component k
  Quaternion q;
  q[0] = (R(j, i) - R(i, j)) / v4;
  q[1 + k] = 0.25 * v4;
  q[1 + i] = (R(i, k) + R(k, i)) / v4;
  q[1 + j] = (R(j, k) + R(k, j)) / v4;
  return q;
}

}  // namespace

Matrix3 hat(const Vector3& phi) {
  Matrix3 result;
  result << 0, -phi.z(), phi.y(),  //
      phi.z(), 0, -phi.x(),        //
      -phi.y(), phi.x(), 0;
  return result;
}

Matrix3 exp(const Vector3& phi) { return matrix(quaternion(phi)); }

Vector3 log(const Matrix3& R) { return log(extract_quaternion(R)); }

Matrix3 right_jacobian(const Vector3& phi) {
  const double angle = norm(phi);
  return Matrix3::Identity() - cosine_deficit(angle) * hat(phi) +
         sine_deficit(angle) * hat_squared(phi);
}

// J_r^-1 = I + 1/2 hat + (1 - x cot x) / (4 x^2) hat^2 with x = |phi| / 2 [Sola17]. The fraction
// equals ((1 - cos x) / x^2 - (x - sin x) / x^3) / (4 sin(x) / x), which stays accurate at 0.
Matrix3 inverse_right_jacobian(const Vector3& phi) {
  const double x = 0.5 * norm(phi);
  const double coefficient = (cosine_deficit(x) - sine_deficit(x)) / (4 * sinc(x));
  return Matrix3::Identity() + 0.5 * hat(phi) + coefficient * hat_squared(phi);
}

Matrix3 nearest(const Matrix3& M) {
  const Eigen::JacobiSVD<Matrix3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Vector3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

Quaternion quaternion(const Vector3& phi) {
  const double half = 0.5 * norm(phi);
  const double scale = 0.5 * sinc(half);
  return {std::cos(half), scale * phi.x(), scale * phi.y(), scale * phi.z()};
}

Vector3 log(const Quaternion& q) {
  const double sign = q[0] < 0 ? -1.0 : 1.0;  // q and -q are the same rotation
  const Vector3 v = q.tail<3>();
  const double sine = norm(v);
  if (sine == 0) return Vector3::Zero();
  return (sign * (2 * std::atan2(sine, sign * q[0]) / sine)) * v;
}

Quaternion multiply(const Quaternion& p, const Quaternion& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
          p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
          p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}

Vector3 compose(const Vector3& phi, const Vector3& delta) {
  return log(multiply(quaternion(phi), quaternion(delta)));
}

}  // namespace raybundle::so3
