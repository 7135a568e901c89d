#include <raybundle/models/alignment.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <raybundle/models/error.h>
#include <raybundle/models/rotation.h>
#include <raybundle/models/statistics.h>

namespace raybundle {
namespace {

using Eigen::Map;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Points = Map<const Matrix3Xd>;

std::size_t index(std::int64_t i) { return static_cast<std::size_t>(i); }

Points as_points(const std::vector<double>& x) {
  return {x.data(), 3, static_cast<Eigen::Index>(x.size() / 3)};
}

void check_sizes(const std::vector<double>& from, const std::vector<double>& to) {
  if (from.size() == to.size() && from.size() % 3 == 0) return;
  throw InputError(
      "alignment", 0,
      std::to_string(from.size()) + " and " + std::to_string(to.size()) + " coordinates",
      "as many of either, a multiple of 3");
}

/// Points about their mean, as multiples of the largest coordinate: squares cannot overflow.
struct Centred {
  explicit Centred(const Points& points) : mean(points.rowwise().mean()) {
    shape = points.colwise() - mean;
    size = shape.cwiseAbs().maxCoeff();
    // What remains of points in one place is rounding.
    constexpr double eps = std::numeric_limits<double>::epsilon();
    is_one_place = !(size > 8 * eps * points.cwiseAbs().maxCoeff());
    if (!is_one_place) shape /= size;
  }
  Vector3d mean;
  Matrix3Xd shape;
  double size = 0;
  bool is_one_place = false;
};

/// The rotation nearest to M, and sum of the singular values with the sign it needs.
struct NearestRotation {
  explicit NearestRotation(const Matrix3d& M) {
    const Eigen::JacobiSVD<Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double sign = (svd.matrixU() * svd.matrixV()).determinant() < 0 ? -1 : 1;
    const Vector3d S(1, 1, sign);  // [Umeyama91, Eq. 43]
    R = svd.matrixU() * S.asDiagonal() * svd.matrixV().transpose();
    trace = S.dot(svd.singularValues());
    largest = svd.singularValues()[0];
  }
  Matrix3d R;
  double trace;
  double largest;
};

void append(std::vector<double>& list, const double* x) { list.insert(list.end(), x, x + 3); }

std::vector<char> marks(std::int64_t count, const std::vector<std::int32_t>& indices) {
  std::vector<char> seen(index(count), 0);
  for (const std::int32_t i : indices) seen[index(i)] = 1;
  return seen;
}

/// Pairs of coordinates of what is marked.
struct Pairs {
  Pairs(const std::vector<char>& marked, const std::vector<double>& from,
        const std::vector<double>& to) {
    for (std::size_t i = 0; i < marked.size(); ++i) {
      if (marked[i] == 0) continue;
      append(a, &from[3 * i]);
      append(b, &to[3 * i]);
    }
  }
  std::vector<double> a;
  std::vector<double> b;
};

/// The marked take the next value each, the others NaN.
std::vector<double> spread(const std::vector<char>& marked, const std::vector<double>& values) {
  std::vector<double> all(marked.size(), std::numeric_limits<double>::quiet_NaN());
  std::size_t next = 0;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    if (marked[i] != 0) all[i] = values[next++];
  }
  return all;
}

Matrix3d rotation(const Problem& problem, std::size_t camera) {
  return so3::exp(Map<const Vector3d>(&problem.cameras[camera * Problem::camera_size]));
}

/// Mean angle between R_cw of the truth and R_cw Q^T, with the Q that fits best over all.
double mean_rotation_error(const std::vector<char>& marked, const Problem& problem,
                           const Problem& truth) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t j = 0; j < marked.size(); ++j) {
    if (marked[j] != 0) sum += rotation(truth, j).transpose() * rotation(problem, j);
  }
  const Matrix3d Q = NearestRotation(sum).R;
  double angles = 0;
  std::int64_t count = 0;
  for (std::size_t j = 0; j < marked.size(); ++j) {
    if (marked[j] == 0) continue;
    const Matrix3d difference = rotation(truth, j) * Q * rotation(problem, j).transpose();
    angles += so3::log(difference).norm();
    ++count;
  }
  constexpr double degrees = 180 / 3.14159265358979323846;
  return count == 0 ? 0 : degrees * angles / static_cast<double>(count);
}

void check_counts(const char* what, std::int64_t truth, std::int64_t problem) {
  if (truth == problem) return;
  throw InputError("truth", 0, std::to_string(truth) + " " + what,
                   std::to_string(problem) + ", as in the problem");
}

void compare_cameras(const Problem& problem, const Problem& truth, TruthErrors& errors) {
  const std::vector<char> cameras = marks(problem.camera_count(), problem.observation_camera);
  const Pairs centres(cameras, camera_centres(problem), camera_centres(truth));
  errors.cameras = static_cast<std::int64_t>(centres.a.size() / 3);
  errors.camera_alignment = align(centres.a, centres.b);
  const std::vector<double> of_centres = distances(errors.camera_alignment, centres.a, centres.b);
  errors.camera_rmse = root_mean_square(of_centres);
  errors.camera_errors = spread(cameras, of_centres);
  errors.rotation_mean = mean_rotation_error(cameras, problem, truth);
}

void compare_points(const Problem& problem, const Problem& truth, TruthErrors& errors) {
  const std::vector<char> points = marks(problem.point_count(), problem.observation_point);
  const Pairs places(points, problem.points, truth.points);
  errors.points = static_cast<std::int64_t>(places.a.size() / 3);
  const std::vector<double> by_cameras = distances(errors.camera_alignment, places.a, places.b);
  errors.point_rmse_by_cameras = root_mean_square(by_cameras);
  errors.point_median = upper_median(by_cameras);
  errors.point_errors = spread(points, by_cameras);
  errors.point_alignment = align(places.a, places.b);
  const std::vector<double> own = distances(errors.point_alignment, places.a, places.b);
  errors.point_rmse = root_mean_square(own);
  errors.point_median_own = upper_median(own);
}

}  // namespace

Similarity align(const std::vector<double>& from, const std::vector<double>& to) {
  check_sizes(from, to);
  Similarity S;
  if (from.empty()) return S;
  const Centred a(as_points(from));
  const Centred b(as_points(to));
  S.t = b.mean - a.mean;
  if (a.is_one_place || b.is_one_place) return S;
  const NearestRotation nearest(b.shape * a.shape.transpose());
  constexpr double eps = std::numeric_limits<double>::epsilon();
  if (!(nearest.largest > 8 * eps * a.shape.norm() * b.shape.norm())) return S;
  S.R = nearest.R;
  S.scale = b.size / a.size * (nearest.trace / a.shape.squaredNorm());
  S.t = b.mean - S.scale * (S.R * a.mean);
  return S;
}

std::vector<double> distances(const Similarity& S, const std::vector<double>& from,
                              const std::vector<double>& to) {
  check_sizes(from, to);
  std::vector<double> result;
  result.reserve(from.size() / 3);
  const Points a = as_points(from);
  const Points b = as_points(to);
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    result.push_back((b.col(i) - S(a.col(i))).stableNorm());
  }
  return result;
}

double root_mean_square(const std::vector<double>& values) {
  if (values.empty()) return 0;
  const Map<const Eigen::VectorXd> x(values.data(), static_cast<Eigen::Index>(values.size()));
  return x.stableNorm() / std::sqrt(static_cast<double>(values.size()));
}

std::vector<Eigen::Matrix3d> camera_rotations(const Problem& problem) {
  std::vector<Eigen::Matrix3d> result;
  result.reserve(index(problem.camera_count()));
  for (std::size_t j = 0; j < index(problem.camera_count()); ++j) {
    result.push_back(rotation(problem, j));
  }
  return result;
}

std::vector<double> camera_centres(const Problem& problem) {
  std::vector<double> centres;
  centres.reserve(index(3 * problem.camera_count()));
  for (std::size_t j = 0; j < index(problem.camera_count()); ++j) {
    const Map<const Vector3d> t_cw(&problem.cameras[j * Problem::camera_size + 3]);
    const Vector3d P = -(rotation(problem, j).transpose() * t_cw);
    append(centres, P.data());
  }
  return centres;
}

TruthErrors compare_with_truth(const Problem& problem, const Problem& truth) {
  check_counts("cameras", truth.camera_count(), problem.camera_count());
  const bool has_points = !truth.points.empty();
  if (has_points) check_counts("points", truth.point_count(), problem.point_count());
  TruthErrors errors;
  compare_cameras(problem, truth, errors);
  if (has_points) compare_points(problem, truth, errors);
  return errors;
}

}  // namespace raybundle
