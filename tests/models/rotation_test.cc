#include <raybundle/models/rotation.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <raybundle/models/random.h>
#include <raybundle/tests/support/numeric_jacobian.h>
#include <raybundle/tests/support/taylor.h>

namespace raybundle::so3 {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double pi = std::numbers::pi;
constexpr double epsilon = std::numeric_limits<double>::epsilon();

const std::vector<double> angles = {0,         1e-300,    1e-160,    1e-20,      1e-12, 1e-9,
                                    1e-8,      1e-7,      1e-5,      1e-4,       1e-3,  0.1,
                                    0.5,       0.999999,  1,         1.000001,   2,     3,
                                    pi - 1e-3, pi - 1e-6, pi - 1e-9, pi - 1e-12, pi};

Vector3d random_axis(Random& random) {
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return Vector3d(x, y, z).normalized();
}

/// Axis-aligned, in the coordinate planes, nearly aligned, and random.
std::vector<Vector3d> axes() {
  std::vector<Vector3d> result;
  for (int k = 0; k < 3; ++k) {
    result.push_back(Vector3d::Unit(k));
    result.push_back(-Vector3d::Unit(k));
    result.push_back((Vector3d::Unit(k) - Vector3d::Unit((k + 1) % 3)).normalized());
    result.push_back((Vector3d::Unit(k) + 1e-9 * Vector3d::Ones()).normalized());
  }
  result.push_back(Vector3d::Ones().normalized());
  Random random(7);
  for (int k = 0; k < 20; ++k) result.push_back(random_axis(random));
  return result;
}

/// Distance of two rotation vectors as rotations: near pi, phi and its opposite almost coincide.
double distance(const Vector3d& a, const Vector3d& b) {
  const double direct = (a - b).stableNorm();
  const double angle = a.stableNorm();
  if (angle < pi - 1e-10) return direct;
  return std::min(direct, (a + b * ((2 * pi - b.norm()) / b.norm())).norm());
}

template <class Body>
void for_all_rotations(const Body& body) {
  for (const double angle : angles) {
    for (const Vector3d& axis : axes()) {
      SCOPED_TRACE(::testing::Message() << "angle " << angle << " axis " << axis.transpose());
      body(Vector3d(angle * axis));
    }
  }
}

TEST(Rotation, HatIsTheCrossProduct) {
  const Vector3d a(1, -2, 3), b(0.5, 4, -1);
  EXPECT_EQ(hat(a) * b, a.cross(b));
}

TEST(Rotation, ExpIsARotationByTheAngleAboutTheAxis) {
  for_all_rotations([](const Vector3d& phi) {
    const Matrix3d R = exp(phi);
    EXPECT_LE((R * R.transpose() - Matrix3d::Identity()).cwiseAbs().maxCoeff(), 8 * epsilon);
    EXPECT_NEAR(R.determinant(), 1, 8 * epsilon);
    const double angle = phi.stableNorm();
    if (angle == 0) {
      EXPECT_EQ(R, Matrix3d(Matrix3d::Identity()));
      return;
    }
    const Vector3d n = phi / angle;  // Rodrigues' formula as printed [Qu18, Eq. 2.6]
    const Matrix3d nn = n * n.transpose();
    const Matrix3d rodrigues =
        (Matrix3d::Identity() - nn) * std::cos(angle) + hat(n) * std::sin(angle) + nn;
    EXPECT_LE((R - rodrigues).cwiseAbs().maxCoeff(), 8 * epsilon);
  });
}

TEST(Rotation, LogUndoesExp) {
  for_all_rotations([](const Vector3d& phi) {
    // Small angles keep their relative accuracy, large ones the accuracy of the matrix entries.
    const double tolerance = 8 * epsilon * phi.stableNorm();
    EXPECT_LE(distance(log(exp(phi)), phi), tolerance);
    EXPECT_LE(distance(log(quaternion(phi)), phi), tolerance);
    const Quaternion opposite = -quaternion(phi);
    EXPECT_LE(distance(log(opposite), phi), tolerance);
  });
}

TEST(Rotation, ExpUndoesLog) {
  for_all_rotations([](const Vector3d& phi) {
    const Matrix3d R = exp(phi);
    EXPECT_LE((exp(log(R)) - R).cwiseAbs().maxCoeff(), 16 * epsilon);
    EXPECT_LE(log(R).norm(), pi * (1 + epsilon));
  });
}

TEST(Rotation, LogOfHalfTurnsWrittenByHand) {
  EXPECT_LE(
      (log(Matrix3d(Vector3d(1, -1, -1).asDiagonal())).cwiseAbs() - Vector3d(pi, 0, 0)).norm(),
      epsilon);
  EXPECT_LE(
      (log(Matrix3d(Vector3d(-1, 1, -1).asDiagonal())).cwiseAbs() - Vector3d(0, pi, 0)).norm(),
      epsilon);
  EXPECT_LE(
      (log(Matrix3d(Vector3d(-1, -1, 1).asDiagonal())).cwiseAbs() - Vector3d(0, 0, pi)).norm(),
      epsilon);
  Matrix3d swap;  // half a turn about (1, 1, 0)
  swap << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  const Vector3d phi = log(swap);
  EXPECT_NEAR(phi.norm(), pi, 4 * epsilon);
  EXPECT_NEAR(phi.x(), phi.y(), 4 * epsilon);
  EXPECT_NEAR(phi.z(), 0, 4 * epsilon);
}

TEST(Rotation, AnglesBeyondPiAreTheSameRotation) {
  Random random(11);
  for (const double angle : {pi + 1e-9, 4.0, 2 * pi - 1e-6, 2 * pi, 7.0, 100.0}) {
    const Vector3d axis = random_axis(random);
    const double wrapped = std::remainder(angle, 2 * pi);
    EXPECT_LE((exp(angle * axis) - exp(wrapped * axis)).norm(), 8 * epsilon * (1 + angle));
    EXPECT_LE((log(exp(angle * axis)) - wrapped * axis).norm(), 8 * epsilon * (1 + angle));
  }
}

TEST(Rotation, QuaternionIsUnitAndTurnsLikeTheMatrix) {
  for_all_rotations([](const Vector3d& phi) {
    const Quaternion q = quaternion(phi);
    EXPECT_NEAR(q.norm(), 1, 4 * epsilon);
    const Eigen::Quaterniond oracle(q[0], q[1], q[2], q[3]);
    EXPECT_LE((oracle.toRotationMatrix() - exp(phi)).cwiseAbs().maxCoeff(), 8 * epsilon);
  });
}

TEST(Rotation, MultiplyIsTheMatrixProduct) {
  Random random(3);
  for (int k = 0; k < 50; ++k) {
    const Vector3d a = random.uniform(0, 3) * random_axis(random);
    const Vector3d b = random.uniform(0, 3) * random_axis(random);
    const Matrix3d product = exp(a) * exp(b);
    EXPECT_LE((exp(log(multiply(quaternion(a), quaternion(b)))) - product).norm(), 16 * epsilon);
    EXPECT_LE((exp(compose(a, b)) - product).norm(), 16 * epsilon);
  }
}

TEST(Rotation, ComposeKeepsTinyUpdates) {
  const Vector3d tiny(1e-200, -3e-201, 2e-200);
  EXPECT_LE((compose(Vector3d::Zero(), tiny) - tiny).stableNorm(), 4 * epsilon * 1e-200);
  EXPECT_LE((compose(tiny, Vector3d::Zero()) - tiny).stableNorm(), 4 * epsilon * 1e-200);
}

TEST(Rotation, LongChainsStayConsistent) {
  // 5000 steps forth and the same steps back, through every angle many times.
  Random random(5);
  const Vector3d start(0.3, -0.2, 0.1);
  std::vector<Vector3d> steps;
  Vector3d phi = start;
  Matrix3d product = exp(start);
  for (int k = 0; k < 5000; ++k) {
    steps.push_back(random.uniform(0, 0.5) * random_axis(random));
    phi = compose(phi, steps.back());
    product = product * exp(steps.back());
  }
  EXPECT_LE((exp(phi) - product).norm(), 1e-12);
  EXPECT_LE((exp(phi) * exp(phi).transpose() - Matrix3d::Identity()).norm(), 16 * epsilon);
  for (std::size_t k = steps.size(); k-- > 0;) phi = compose(phi, -steps[k]);
  EXPECT_LE((phi - start).norm(), 1e-12);
}

TEST(Rotation, RightJacobianMatchesNumericDerivatives) {
  Random random(13);
  for (const double angle : {0.0, 1e-9, 1e-4, 0.1, 0.999, 1.001, 3.0, pi - 1e-6, pi, 4.0, 6.0}) {
    const Vector3d phi = angle * random_axis(random);
    // The limit that defines J_r [Qu18, Eq. 3.26].
    const auto difference = [&](const VectorXd& d) -> VectorXd {
      return log(Matrix3d(exp(phi).transpose() * exp(phi + Vector3d(d))));
    };
    const Eigen::MatrixXd numeric = test::numeric_jacobian(difference, Vector3d::Zero());
    EXPECT_LE((right_jacobian(phi) - numeric).norm(), 1e-10) << "angle " << angle;
  }
}

TEST(Rotation, RightJacobianHasTaylorSlopeTwo) {
  Random random(17);
  for (const double angle : {0.01, 0.1, 0.9, 1.1, 3.0, pi, 5.0}) {
    const Vector3d phi = angle * random_axis(random);
    const Vector3d d = random_axis(random);
    const Vector3d J_d = right_jacobian(phi) * d;
    // exp(phi + tau d) = exp(phi) exp(tau J_r d) + O(tau^2), entry by entry.
    const auto along = [&](double tau) -> VectorXd {
      const Matrix3d R = exp(Vector3d(phi + tau * d));
      return Eigen::Map<const VectorXd>(R.data(), 9);
    };
    const Matrix3d derivative = exp(phi) * hat(J_d);
    const Eigen::Map<const VectorXd> flat(derivative.data(), 9);
    EXPECT_TRUE(test::has_taylor_slope_two(along, flat)) << "angle " << angle;
    EXPECT_FALSE(test::has_taylor_slope_two(along, 1.0001 * flat)) << "angle " << angle;
  }
}

TEST(Rotation, InverseRightJacobianIsTheInverse) {
  for_all_rotations([](const Vector3d& phi) {
    const Matrix3d product = right_jacobian(phi) * inverse_right_jacobian(phi);
    EXPECT_LE((product - Matrix3d::Identity()).cwiseAbs().maxCoeff(), 16 * epsilon);
  });
  for (const double angle : {4.0, 5.0, 6.0, 6.2}) {
    const Vector3d phi = angle * Vector3d(2, -1, 0.5).normalized();
    const Matrix3d product = right_jacobian(phi) * inverse_right_jacobian(phi);
    EXPECT_LE((product - Matrix3d::Identity()).norm(), 1e-12) << "angle " << angle;
  }
}

TEST(Rotation, JacobiansAgreeWithSeriesInLongDouble) {
  // sum_k (-hat)^k / (k + 1)! is J_r; the direction along which hat^2 matters shows the second
  // coefficient to full relative accuracy.
  for (const double angle : {1e-3, 0.1, 0.5, 0.99, 1.0, 1.01, 1.5, 2.0, 3.0}) {
    long double c = 0;  // (a - sin a) / a^3
    long double term = 1.0L / 6.0L;
    for (int k = 0; k < 30; ++k) {
      c += term;
      term *= -static_cast<long double>(angle) * angle / ((2 * k + 4.0L) * (2 * k + 5.0L));
    }
    const double entry = 1 - right_jacobian(Vector3d(0, 0, angle))(0, 0);  // c a^2
    const double expected = static_cast<double>(c * angle * angle);
    EXPECT_NEAR(entry, expected, 4 * epsilon * expected + epsilon) << "angle " << angle;
  }
}

}  // namespace
}  // namespace raybundle::so3
