#pragma once

#include <Eigen/Core>

/// Rotations of 3-space, SO(3), by their rotation vector phi (radians, right-hand rule).
/// Notation: hat(phi) x = phi cross x; exp(phi) = Exp(phi) of [Qu18, Eq. 3.25].
/// Every function is accurate for any angle: series near 0, quaternion forms near pi.
namespace raybundle::so3 {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
/// Unit quaternion, scalar first: (cos(a/2), sin(a/2) n).
using Quaternion = Eigen::Vector4d;

Matrix3 hat(const Vector3& phi);                     ///< [Qu18, Eq. 3.24]
Matrix3 exp(const Vector3& phi);                     ///< rotation matrix [Qu18, Eq. 2.6]
Vector3 log(const Matrix3& R);                       ///< rotation vector, angle in [0, pi]
Matrix3 right_jacobian(const Vector3& phi);          ///< J_r [Qu18, Eq. 3.26]
Matrix3 inverse_right_jacobian(const Vector3& phi);  ///< J_r^-1, for |phi| < 2 pi

Matrix3 nearest(const Matrix3& M);  ///< the rotation R with the least |R - M|, of Frobenius

Quaternion quaternion(const Vector3& phi);  ///< exp(phi) as a unit quaternion
Vector3 log(const Quaternion& q);           ///< rotation vector, angle in [0, pi]
Quaternion multiply(const Quaternion& p, const Quaternion& q);

/// log(exp(phi) exp(delta)): the rotation vector after a local update [Qu18, Eq. 4.1].
Vector3 compose(const Vector3& phi, const Vector3& delta);

}  // namespace raybundle::so3
