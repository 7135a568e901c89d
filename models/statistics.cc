// Reprojection errors with the lens of BAL, written out once more on purpose: these figures check
// what the solver says, so they do not come from the same code.

#include <raybundle/models/statistics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include <Eigen/Core>

#include <raybundle/models/rotation.h>

namespace raybundle {
namespace {

using Eigen::Map;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::size_t index(std::int64_t i) { return static_cast<std::size_t>(i); }

/// What a range of observations adds up to.
struct RangeSums {
  double squared = 0;  // sum |r|^2
  double largest_squared = 0;
  std::int64_t behind = 0;
};

/// The larger one, or NaN where there is one.
double larger(double a, double b) { return a >= b || std::isnan(a) ? a : b; }

class Reprojection {
 public:
  explicit Reprojection(const Problem& problem) : problem_(problem) {
    rotations_.reserve(index(problem.camera_count()));
    for (std::int64_t j = 0; j < problem.camera_count(); ++j) {
      rotations_.push_back(so3::exp(Map<const Vector3d>(camera(j))));
    }
  }

  /// |r|^2 of observation k; `behind` counts it when its point is behind its camera.
  double squared_residual(std::int64_t k, std::int64_t& behind) const;

  /// Of all; the tree of the pairwise summation is the same for any number of threads.
  RangeSums sums(std::int64_t count, linalg::ThreadPool& pool) const {
    constexpr std::int64_t branches = 64;
    std::array<RangeSums, branches> parts;
    const linalg::Chunks pieces = linalg::chunks(count, 1, branches);
    pool.run(pieces.pieces,
             [&](std::int64_t i) { parts[index(i)] = sums(pieces.begin(i), pieces.end(i)); });
    for (std::size_t width = branches / 2; width > 0; width /= 2) {
      for (std::size_t i = 0; i < width; ++i) parts[i] = both(parts[2 * i], parts[2 * i + 1]);
    }
    return parts[0];
  }

 private:
  static RangeSums both(const RangeSums& left, const RangeSums& right) {
    return {left.squared + right.squared, larger(left.largest_squared, right.largest_squared),
            left.behind + right.behind};
  }

  /// Pairwise summation: the error grows with the logarithm of the count, and the order is fixed.
  RangeSums sums(std::int64_t first, std::int64_t last) const {
    constexpr std::int64_t run_length = 64;
    RangeSums result;
    if (last - first <= run_length) {
      for (std::int64_t k = first; k < last; ++k) add(k, result);
      return result;
    }
    const std::int64_t middle = first + (last - first) / 2;
    return both(sums(first, middle), sums(middle, last));
  }

  const double* camera(std::int64_t j) const {
    return &problem_.cameras[index(j * Problem::camera_size)];
  }

  void add(std::int64_t k, RangeSums& sums) const {
    const double squared = squared_residual(k, sums.behind);
    sums.squared += squared;
    sums.largest_squared = larger(squared, sums.largest_squared);
  }

  const Problem& problem_;
  std::vector<Eigen::Matrix3d> rotations_;  // R_cw per camera
};

/// X_c = R_cw X + t_cw, p = -X_c.xy / X_c.z, u = f (1 + k1 |p|^2 + k2 |p|^4) p
/// [Qu18, Eq. 3.5-3.7].
double Reprojection::squared_residual(std::int64_t k, std::int64_t& behind) const {
  const std::int64_t j = problem_.observation_camera[index(k)];
  const std::int64_t i = problem_.observation_point[index(k)];
  const double* c = camera(j);
  const Map<const Vector3d> X(&problem_.points[index(i * Problem::point_size)]);
  const Map<const Vector2d> observed(&problem_.observations[index(2 * k)]);
  const Vector3d X_c = rotations_[index(j)] * X + Map<const Vector3d>(c + 3);
  const Vector2d p = -X_c.head<2>() / X_c.z();
  const double p2 = p.squaredNorm();
  const Vector2d u =
      c[6] * (1 + p2 * (c[7] + p2 * c[8])) * Vector2d(p.x(), problem_.aspect * p.y());
  behind += X_c.z() >= 0 ? 1 : 0;
  return (u - observed).squaredNorm();
}

/// visit(k, |r|^2) of every observation; what cannot be projected is infinitely far off.
template <class Visit>
void visit_squares(const Problem& problem, const Visit& visit) {
  const Reprojection reprojection(problem);
  std::int64_t unused = 0;
  for (std::int64_t k = 0; k < problem.observation_count(); ++k) {
    const double squared = reprojection.squared_residual(k, unused);
    visit(k, std::isnan(squared) ? std::numeric_limits<double>::infinity() : squared);
  }
}

}  // namespace

ReprojectionStatistics reprojection_statistics(const Problem& problem) {
  linalg::ThreadPool alone(1);
  return reprojection_statistics(problem, alone);
}

ReprojectionStatistics reprojection_statistics(const Problem& problem, linalg::ThreadPool& pool) {
  ReprojectionStatistics result;
  const std::int64_t count = problem.observation_count();
  if (count == 0) return result;
  const RangeSums sums = Reprojection(problem).sums(count, pool);
  result.cost = 0.5 * sums.squared;
  result.rmse = std::sqrt(sums.squared / static_cast<double>(count));
  result.largest = std::sqrt(sums.largest_squared);
  result.behind_camera = sums.behind;
  return result;
}

ReprojectionBreakdown reprojection_breakdown(const Problem& problem) {
  ReprojectionBreakdown result;
  result.cameras.resize(index(problem.camera_count()));
  result.points.resize(index(problem.point_count()));
  // Squares until the end.
  const auto add = [](ResidualSummary& summary, double squared) {
    ++summary.observations;
    summary.rmse += squared;
    summary.largest = larger(squared, summary.largest);
  };
  const auto finish = [](ResidualSummary& summary) {
    if (summary.observations == 0) return;
    summary.rmse = std::sqrt(summary.rmse / static_cast<double>(summary.observations));
    summary.largest = std::sqrt(summary.largest);
  };
  const Reprojection reprojection(problem);
  std::int64_t behind = 0;
  for (std::int64_t k = 0; k < problem.observation_count(); ++k) {
    const double squared = reprojection.squared_residual(k, behind);
    add(result.cameras[index(problem.observation_camera[index(k)])], squared);
    add(result.points[index(problem.observation_point[index(k)])], squared);
  }
  std::for_each(result.cameras.begin(), result.cameras.end(), finish);
  std::for_each(result.points.begin(), result.points.end(), finish);
  return result;
}

double upper_median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<double> median_residuals(const Problem& problem) {
  std::vector<std::vector<double>> squares(index(problem.camera_count()));
  visit_squares(problem, [&](std::int64_t k, double squared) {
    squares[index(problem.observation_camera[index(k)])].push_back(squared);
  });
  std::vector<double> medians;
  medians.reserve(squares.size());
  for (auto& of_camera : squares) medians.push_back(std::sqrt(upper_median(std::move(of_camera))));
  return medians;
}

RobustStatistics robust_statistics(const Problem& problem, double scale) {
  RobustStatistics result;
  std::vector<double> residuals;
  residuals.reserve(index(problem.observation_count()));
  visit_squares(problem, [&](std::int64_t, double squared) {
    residuals.push_back(std::sqrt(squared));
    result.within += residuals.back() <= scale ? 1 : 0;
  });
  result.median = upper_median(std::move(residuals));
  return result;
}

}  // namespace raybundle
