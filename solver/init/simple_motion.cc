#include <raybundle/solver/init/simple_motion.h>

#include <raybundle/models/rotation.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <cmath>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int rounds = 10;

// Squared pixels of both that a squared radian between b and H a is.
double squared_pixels(const RayPair& pair) {
  const double p_a = pair.pixels_a, p_b = pair.pixels_b;
  return 1 / (1 / (p_a * p_a) + 1 / (p_b * p_b));
}

// Calls take(i, weight) with the weights of a squared radian, in the first round without a loss,
// then with Cauchy's at H.
template <class Take>
void weighted(const Matrix3d& H, bool first, const RayPairs& pairs,
              std::span<const std::int32_t> which, double scale, Take&& take) {
  for (const std::int32_t i : which) {
    const RayPair pair = pairs.pair(i);
    const double robust = first ? 1 : 1 / (1 + squared_error(H, pair) / (scale * scale));
    take(i, robust * squared_pixels(pair));
  }
}

}  // namespace

double squared_error(const Matrix3d& H, const RayPair& pair) {
  return (pair.b - (H * pair.a).normalized()).squaredNorm() * squared_pixels(pair);
}

Matrix3d pure_rotation(const RayPairs& pairs, std::span<const std::int32_t> which, double scale) {
  Matrix3d R = Matrix3d::Identity();
  for (int round = 0; round < rounds; ++round) {
    Matrix3d sum = Matrix3d::Zero();
    weighted(R, round == 0, pairs, which, scale, [&](std::int32_t i, double weight) {
      sum += weight * pairs.b.col(i) * pairs.a.col(i).transpose();
    });
    R = so3::nearest(sum);
  }
  return R;
}

// b x H a = 0, each pair with the weight that makes it pixels at the last H.
Matrix3d homography(const RayPairs& pairs, std::span<const std::int32_t> which, double scale) {
  using Matrix9 = Eigen::Matrix<double, 9, 9>;
  Matrix3d H = Matrix3d::Identity();
  for (int round = 0; round < rounds; ++round) {
    Matrix9 sum = Matrix9::Zero();
    weighted(H, round == 0, pairs, which, scale, [&](std::int32_t i, double weight) {
      const Vector3d a = pairs.a.col(i), b = pairs.b.col(i);
      const Matrix3d across = Matrix3d::Identity() - b * b.transpose();
      const Matrix3d outer = weight / (H * a).squaredNorm() * a * a.transpose();
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) sum.block<3, 3>(3 * r, 3 * c) += across(r, c) * outer;
      }
    });
    const Eigen::SelfAdjointEigenSolver<Matrix9> eigen(sum);
    const Eigen::Matrix<double, 9, 1> rows = eigen.eigenvectors().col(0);
    H = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
    double facing = 0;
    for (const std::int32_t i : which)
      facing += pairs.b.col(i).dot(H * pairs.a.col(i)) > 0 ? 1 : -1;
    if (facing < 0) H = -H;
  }
  return H;
}

std::int64_t explained(const Matrix3d& H, const RayPairs& pairs,
                       std::span<const std::int32_t> which, double pixels) {
  std::int64_t count = 0;
  for (const std::int32_t i : which) {
    count += squared_error(H, pairs.pair(i)) < pixels * pixels ? 1 : 0;
  }
  return count;
}

// H scaled to the middle singular value 1 is R + t n^T / d. Two directions u in the plane of the
// outer singular vectors keep their length, as all of the scene's plane does in parallel to it.
std::vector<RelativePose> poses_of_plane(const Matrix3d& H_any) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(H_any.transpose() * H_any);
  const Matrix3d H = H_any / std::sqrt(eigen.eigenvalues()[1]);
  const double least = eigen.eigenvalues()[0] / eigen.eigenvalues()[1];
  const double most = eigen.eigenvalues()[2] / eigen.eigenvalues()[1];
  if (!(most - least > 1e-9)) return {};
  Matrix3d V = eigen.eigenvectors();
  const Vector3d v1 = V.col(2), v2 = V.col(1), v3 = V.col(0);
  const double c = std::sqrt(std::max(1 - least, 0.0) / (most - least));
  const double s = std::sqrt(std::max(most - 1, 0.0) / (most - least));
  std::vector<RelativePose> result;
  for (const double sign : {1.0, -1.0}) {
    const Vector3d u = c * v1 + sign * s * v3, Hu = H * u, Hv = H * v2;
    Matrix3d before, after;
    before << v2, u, v2.cross(u);
    after << Hv, Hu, Hv.cross(Hu);
    const Matrix3d R = after * before.transpose();
    const Vector3d t = (H - R) * v2.cross(u);
    if (t.norm() > 1e-9) result.push_back({R, t.normalized()});
  }
  return result;
}

}  // namespace raybundle::init
