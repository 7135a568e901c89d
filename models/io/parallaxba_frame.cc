#include <raybundle/models/io/parallaxba_frame.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cmath>

namespace raybundle::io {
namespace {

using so3::Matrix3;
using so3::Vector3;

// Theirs to ours and back.
const Vector3 flip(1, -1, -1);

// A rotation about one axis by an angle, with the signs of [Zhao15].
Matrix3 about(int axis, double angle) {
  return Eigen::AngleAxisd(-angle, Vector3::Unit(axis)).toRotationMatrix();
}

}  // namespace

Matrix3 parallaxba_rotation(const std::array<double, 3>& angles) {
  return flip.asDiagonal() * (about(0, angles[2]) * about(1, angles[1]) * about(2, angles[0]));
}

std::array<double, 3> parallaxba_angles(const Matrix3& R_cw) {
  const Matrix3 theirs = flip.asDiagonal() * R_cw;
  const double beta = std::atan2(-theirs(0, 2), std::hypot(theirs(0, 0), theirs(0, 1)));
  const double alpha = std::atan2(theirs(0, 1), theirs(0, 0));
  // What is left is a rotation about x, however small cos(beta) is.
  const Matrix3 rest = theirs * about(2, alpha).transpose() * about(1, beta).transpose();
  return {alpha, beta, std::atan2(rest(1, 2), rest(1, 1))};
}

}  // namespace raybundle::io
