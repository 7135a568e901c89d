#include <raybundle/solver/init/triangulation.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Minimises sum w |(I - d d^T) (X - P)|^2, with w first 1 and then pixels^2 / distance^2.
std::optional<Vector3d> nearest_point(const std::vector<WorldRay>& rays,
                                      const std::vector<std::uint8_t>& used) {
  std::optional<Vector3d> X;
  for (int round = 0; round < 4; ++round) {
    Matrix3d A = Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (used[i] == 0) continue;
      const Vector3d& d = rays[i].direction;
      const double distance = X ? std::max((*X - rays[i].centre).norm(), 1e-12) : 1;
      const double w = X ? rays[i].pixels * rays[i].pixels / (distance * distance) : 1;
      const Matrix3d across = w * (Matrix3d::Identity() - d * d.transpose());
      A += across;
      b += across * rays[i].centre;
    }
    X = A.ldlt().solve(b);
    if (!X->allFinite()) return {};
  }
  return X;
}

double largest_angle(const std::vector<WorldRay>& rays, const std::vector<std::uint8_t>& used) {
  double largest = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    for (std::size_t j = i + 1; j < rays.size() && used[i] != 0; ++j) {
      if (used[j] == 0) continue;
      const Vector3d &a = rays[i].direction, &b = rays[j].direction;
      largest = std::max(largest, std::atan2(a.cross(b).norm(), a.dot(b)));
    }
  }
  return largest;
}

std::vector<std::uint8_t> within(const std::vector<WorldRay>& rays, const Vector3d& X,
                                 double threshold) {
  std::vector<std::uint8_t> result;
  result.reserve(rays.size());
  for (const WorldRay& ray : rays) result.push_back(pixels_off(ray, X) < threshold ? 1 : 0);
  return result;
}

std::int64_t count(const std::vector<std::uint8_t>& used) {
  return std::count(used.begin(), used.end(), 1);
}

// Calls visit(X) for the points that pairs of rays make, of long lists for some of them.
template <class Visit>
void for_pairs(const std::vector<WorldRay>& rays, Visit&& visit) {
  constexpr std::size_t compared = 12;
  const std::size_t stride = (rays.size() + compared - 1) / compared;
  std::vector<std::uint8_t> pair(rays.size(), 0);
  for (std::size_t i = 0; i < rays.size(); i += stride) {
    for (std::size_t j = i + stride; j < rays.size(); j += stride) {
      pair[i] = pair[j] = 1;
      if (const auto X = nearest_point(rays, pair)) visit(*X);
      pair[i] = pair[j] = 0;
    }
  }
}

// What most rays agree with, of the points that pairs of them make.
std::vector<std::uint8_t> agreement(const std::vector<WorldRay>& rays, double threshold) {
  std::vector<std::uint8_t> best(rays.size(), 0);
  for_pairs(rays, [&](const Vector3d& X) {
    std::vector<std::uint8_t> agree = within(rays, X, threshold);
    if (count(agree) > count(best)) best = std::move(agree);
  });
  return best;
}

}  // namespace

double pixels_off(const WorldRay& ray, const Vector3d& X) {
  const Vector3d to = X - ray.centre;
  return ray.pixels * std::atan2(ray.direction.cross(to).norm(), ray.direction.dot(to));
}

Vector3d best_agreed(const std::vector<WorldRay>& rays, const Vector3d& start, double scale) {
  const bool all_near = std::all_of(rays.begin(), rays.end(), [&](const WorldRay& ray) {
    return pixels_off(ray, start) < 2 * scale;
  });
  if (all_near) return start;
  const auto cost = [&](const Vector3d& X) {
    double sum = 0;
    for (const WorldRay& ray : rays) {
      const double error = pixels_off(ray, X) / scale;
      sum += std::log1p(error * error);
    }
    return sum;
  };
  Vector3d best = start;
  double least = cost(start);
  for_pairs(rays, [&](const Vector3d& X) {
    const double there = cost(X);
    if (there < least) least = there, best = X;
  });
  return best;
}

std::optional<Triangulated> triangulated(const std::vector<WorldRay>& rays,
                                         const TriangulationOptions& options) {
  std::vector<std::uint8_t> used(rays.size(), 1);
  std::optional<Vector3d> X;
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (attempt > 0) used = agreement(rays, options.threshold);
    if (count(used) < 2 || largest_angle(rays, used) < options.min_parallax) return {};
    X = nearest_point(rays, used);
    if (!X) return {};
    const std::vector<std::uint8_t> good = within(rays, *X, options.threshold);
    if (attempt == 0 && good == used) return Triangulated{*X, used};
    used = good;
  }
  if (count(used) < 2 || largest_angle(rays, used) < options.min_parallax) return {};
  return Triangulated{*X, used};
}

}  // namespace raybundle::init
