#include <raybundle/models/scenes/geometry.h>

#include <cmath>

namespace raybundle::scenes {
namespace {

/// sum_k (-x2)^k / (first (first + 1) ... (first + 2k)) scaled so that the first term is 1: with
/// first = 2 this is sin(x)/x, with first = 3 it is 2 (1 - cos x)/x^2. For |x| < 1.
double alternating_series(double x2, int first) {
  double sum = 0;
  for (int k = 10; k >= 1; --k) {
    const int d = first + 2 * (k - 1);
    sum = x2 / (d * (d + 1)) * (1 - sum);
  }
  return 1 - sum;
}

struct SineCosine {
  double sine, cosine;
};

/// Halves the angle until the series are good for it, and doubles it again.
SineCosine sine_cosine(double x) {
  if (x > -1 && x < 1) {
    return {x * alternating_series(x * x, 2), 1 - 0.5 * x * x * alternating_series(x * x, 3)};
  }
  const auto [s, c] = sine_cosine(0.5 * x);
  return {2 * s * c, 1 - 2 * s * s};
}

}  // namespace

Vec3 sum(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec3 difference(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec3 scaled(double factor, const Vec3& a) { return {factor * a.x, factor * a.y, factor * a.z}; }
double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

double sine(double x) { return sine_cosine(x).sine; }
double cosine(double x) { return sine_cosine(x).cosine; }

double arctangent(double y, double x) {
  if (x < 0) return pi - arctangent(y, -x);
  if (y > x) return 0.5 * pi - arctangent(x, y);
  double z = y / x;  // in [0, 1]; atan z = 2 atan(z / (1 + sqrt(1 + z^2))), three times
  for (int k = 0; k < 3; ++k) z = z / (1 + std::sqrt(1 + z * z));
  const double z2 = z * z;  // below 0.0097
  double series = 0;
  for (int k = 9; k >= 0; --k) series = 1.0 / (2 * k + 1) - z2 * series;
  return 8 * z * series;
}

Vec3 rotate(const Vec3& phi, const Vec3& v) {
  const double angle2 = phi.x * phi.x + phi.y * phi.y + phi.z * phi.z;
  double a = 0, b = 0;  // sin(angle) / angle and (1 - cos(angle)) / angle^2
  if (angle2 < 1) {
    a = alternating_series(angle2, 2);
    b = 0.5 * alternating_series(angle2, 3);
  } else {
    const double angle = std::sqrt(angle2);
    const auto [s, c] = sine_cosine(angle);
    a = s / angle;
    b = (1 - c) / angle2;
  }
  const Vec3 c = cross(phi, v);
  const Vec3 d = cross(phi, c);
  return {v.x + a * c.x + b * d.x, v.y + a * c.y + b * d.y, v.z + a * c.z + b * d.z};
}

Mat3 rotation_matrix(const Vec3& phi) {
  const Vec3 back = {-phi.x, -phi.y, -phi.z};  // the rows of a rotation are its inverse's columns
  return {rotate(back, {1, 0, 0}), rotate(back, {0, 1, 0}), rotate(back, {0, 0, 1})};
}

Vec3 rotation_vector(const Mat3& rows) {
  // The unit quaternion (w, v), from its largest component, so that no difference cancels.
  const double xx = rows.x.x, yy = rows.y.y, zz = rows.z.z;
  const Vec3 skew = {rows.z.y - rows.y.z, rows.x.z - rows.z.x, rows.y.x - rows.x.y};
  const double xy = rows.x.y + rows.y.x, xz = rows.x.z + rows.z.x, yz = rows.y.z + rows.z.y;
  double w = 0;
  Vec3 v;
  if (xx + yy + zz > 0) {
    w = 1 + xx + yy + zz;
    v = skew;
  } else if (xx >= yy && xx >= zz) {
    w = skew.x;
    v = {1 + xx - yy - zz, xy, xz};
  } else if (yy >= zz) {
    w = skew.y;
    v = {xy, 1 + yy - xx - zz, yz};
  } else {
    w = skew.z;
    v = {xz, yz, 1 + zz - xx - yy};
  }
  if (w < 0) {
    w = -w;
    v = scaled(-1, v);
  }
  const double length = norm(v);
  return length > 0 ? scaled(2 * arctangent(length, w) / length, v) : Vec3{};
}

Vec3 product(const Mat3& rows, const Vec3& v) {
  return {dot(rows.x, v), dot(rows.y, v), dot(rows.z, v)};
}

Vec3 combined(const Mat3& axes, const Vec3& v) {
  return sum(sum(scaled(v.x, axes.x), scaled(v.y, axes.y)), scaled(v.z, axes.z));
}

Mat3 axes_about(const Vec3& z, double roll) {
  const bool upright = z.y * z.y < 0.99;
  const Vec3 across = cross(upright ? Vec3{0, 1, 0} : Vec3{1, 0, 0}, z);
  const Vec3 x = scaled(1 / norm(across), across);
  const Vec3 y = cross(z, x);
  const auto [s, c] = sine_cosine(roll);
  return {sum(scaled(c, x), scaled(s, y)), difference(scaled(c, y), scaled(s, x)), z};
}

Vec3 normal_vector(Random& random, double deviation) {
  Vec3 v;
  v.x = deviation * random.normal();
  v.y = deviation * random.normal();
  v.z = deviation * random.normal();
  return v;
}

Vec3 direction_in_cone(Random& random, double angle) {
  const double z = 1 - random.uniform() * (1 - cosine(angle));  // Archimedes: uniform in height
  const double radius = std::sqrt((1 - z) * (1 + z));
  const double turn = random.uniform(-pi, pi);
  return {radius * cosine(turn), radius * sine(turn), z};
}

}  // namespace raybundle::scenes
