#pragma once

#include <raybundle/models/random.h>

/// The little geometry that scenes are made of, from + - * / and sqrt alone (no C library, no
/// Eigen), so that the same seed gives the same bits everywhere. All that computes with it is
/// compiled with -ffp-contract=off.
namespace raybundle::scenes {

inline constexpr double pi = 3.14159265358979323846;

struct Vec3 {
  double x = 0, y = 0, z = 0;
};

Vec3 sum(const Vec3& a, const Vec3& b);
Vec3 difference(const Vec3& a, const Vec3& b);
Vec3 scaled(double factor, const Vec3& a);
double dot(const Vec3& a, const Vec3& b);
double norm(const Vec3& a);
Vec3 cross(const Vec3& a, const Vec3& b);

double sine(double x);
double cosine(double x);
double arctangent(double y, double x);  ///< atan2 for y >= 0, not both zero: in [0, pi]

/// exp(phi) v by Rodrigues' formula [Qu18, Eq. 2.6].
Vec3 rotate(const Vec3& phi, const Vec3& v);

/// Three rows, or columns.
struct Mat3 {
  Vec3 x, y, z;
};

Mat3 rotation_matrix(const Vec3& phi);            ///< rows of exp(phi)
Vec3 rotation_vector(const Mat3& rows);           ///< the inverse: |phi| <= pi
Vec3 product(const Mat3& rows, const Vec3& v);    ///< rows * v
Vec3 combined(const Mat3& axes, const Vec3& v);   ///< axes.x v.x + axes.y v.y + axes.z v.z
Mat3 axes_about(const Vec3& z, double roll = 0);  ///< right-handed, orthonormal; z a unit vector

Vec3 normal_vector(Random& random, double deviation);  ///< of each component
/// A unit vector less than `angle` from the +z axis, uniform on that part of the sphere.
Vec3 direction_in_cone(Random& random, double angle);

}  // namespace raybundle::scenes
