#include <raybundle/models/alignment.h>
#include <raybundle/models/observation_rows.h>
#include <raybundle/models/statistics.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <vector>

namespace raybundle {
namespace {

using Eigen::Map;
using Eigen::Vector3d;

constexpr std::size_t exact_limit = 32;         // observers that are compared pair by pair
constexpr int sweeps = 4;                       // of more
constexpr double tan2 = 0.0003046792916482916;  // tan(1 degree)^2

bool wider_than_one_degree(const Vector3d& a, const Vector3d& b) {
  const double dot = a.dot(b);
  return dot < 0 || a.cross(b).squaredNorm() > tan2 * dot * dot;
}

// Whether two of the unit vectors differ by more than a degree.
bool has_parallax(const std::vector<Vector3d>& rays) {
  if (rays.size() <= exact_limit) {
    for (std::size_t a = 0; a < rays.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        if (wider_than_one_degree(rays[a], rays[b])) return true;
      }
    }
    return false;
  }
  std::size_t from = 0;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    std::size_t farthest = from;
    for (std::size_t b = 0; b < rays.size(); ++b) {
      if (wider_than_one_degree(rays[from], rays[b])) return true;
      const double distance = (rays[b] - rays[from]).squaredNorm();
      if (distance > (rays[farthest] - rays[from]).squaredNorm()) farthest = b;
    }
    from = farthest;
  }
  return false;
}

// From one to the other of the two places that are farthest apart.
Vector3d widest_baseline(const std::vector<Vector3d>& centres) {
  Vector3d widest = Vector3d::Zero();
  const auto compare = [&](const Vector3d& a, const Vector3d& b) {
    if ((b - a).squaredNorm() > widest.squaredNorm()) widest = b - a;
  };
  if (centres.size() <= exact_limit) {
    for (const Vector3d& a : centres) {
      for (const Vector3d& b : centres) compare(a, b);
    }
    return widest;
  }
  Vector3d from = centres.front();
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (const Vector3d& b : centres) compare(from, b);
    from += widest;
    widest = -widest;  // and back from there
  }
  return widest;
}

// Whether all rays run along the line of the observers' motion, to within a degree.
bool is_collinear(const std::vector<Vector3d>& centres, const std::vector<Vector3d>& rays) {
  const Vector3d line = widest_baseline(centres);
  double size = 0;
  for (const Vector3d& centre : centres) size = std::max(size, centre.cwiseAbs().maxCoeff());
  constexpr double rounding = 1e-12;
  if (!(line.norm() > rounding * size)) return false;  // all at one place
  return std::none_of(rays.begin(), rays.end(), [&](const Vector3d& ray) {
    const double along = ray.dot(line);
    return ray.cross(line).squaredNorm() > tan2 * along * along;
  });
}

}  // namespace

ParallaxStatistics parallax_statistics(const Problem& problem) {
  const std::vector<double> places = camera_centres(problem);
  linalg::ThreadPool alone(1);
  const ObservationRows rows(problem, alone);
  ParallaxStatistics result;
  std::vector<Vector3d> centres, rays;
  for (std::size_t i = 0; i + 1 < rows.begin.size(); ++i) {
    const Map<const Vector3d> X(&problem.points[i * Problem::point_size]);
    const auto first = static_cast<std::size_t>(rows.begin[i]);
    const auto last = static_cast<std::size_t>(rows.begin[i + 1]);
    if (first == last || rows.camera[first] == rows.camera[last - 1]) continue;
    centres.clear();
    rays.clear();
    for (std::size_t row = first; row < last; ++row) {
      centres.emplace_back(&places[3 * static_cast<std::size_t>(rows.camera[row])]);
      rays.push_back((X - centres.back()).stableNormalized());
    }
    if (!has_parallax(rays)) ++result.low;
    if (is_collinear(centres, rays)) ++result.collinear;
  }
  return result;
}

}  // namespace raybundle
