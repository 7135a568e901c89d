#include <raybundle/solver/init/sightings.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/linalg/vector.h>
#include <raybundle/models/rays.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>

namespace raybundle::init {
namespace {

using linalg::index;

// The mean, along and across the radius, of how fast the pixel moves as the ray turns; at least a
// tenth of f, so that rays near the edge of what a lens can see have a bounded weight.
double pixels_per_radian(const double* lens, const Eigen::Vector3d& ray) {
  const double f = std::abs(lens[0]), k1 = lens[1], k2 = lens[2];
  const double n = (ray[0] * ray[0] + ray[1] * ray[1]) / (ray[2] * ray[2]);
  const double along = (1 + n * (3 * k1 + 5 * n * k2)) * (1 + n);
  const double across = (1 + n * (k1 + n * k2)) * std::sqrt(1 + n);
  const double both = along * across;
  return f * std::max(both > 0 ? std::sqrt(both) : 0, 0.1);
}

const double* lens_of(const Problem& problem, std::int64_t observation) {
  const std::int64_t camera = problem.observation_camera[index(observation)];
  return problem.cameras.data() + Problem::camera_size * camera + 6;
}

std::int64_t size_of(const std::vector<std::int32_t>& list) {
  return static_cast<std::int64_t>(list.size());
}

std::optional<std::array<double, 2>> undistorted_pixel(const Problem& problem,
                                                       std::int64_t observation) {
  const double* u = problem.observations.data() + 2 * observation;
  const std::array<double, 2> square = {u[0], u[1] / problem.aspect};
  return undistort(lens_of(problem, observation), square.data());
}

}  // namespace

Sightings::Sightings(const Problem& problem, linalg::ThreadPool& pool) {
  validate(problem, pool);
  if (problem.observation_count() > linalg::most_numbered) {
    throw std::length_error("more than 2^31 observations");
  }
  std::vector<Pixel> undistorted(index(problem.observation_count()));
  linalg::for_entries(problem.observation_count(), pool, [&](std::size_t k) {
    undistorted[k] = undistorted_pixel(problem, static_cast<std::int64_t>(k));
  });
  for (std::int32_t k = 0; k < problem.observation_count(); ++k) {
    if (undistorted[index(k)]) observation_.push_back(k);
  }
  impossible_ = problem.observation_count() - size_of(observation_);
  sort(problem);
  list_by_image();
  take_rays(problem, undistorted, pool);
}

void Sightings::take_rays(const Problem& problem, std::span<const Pixel> undistorted,
                          linalg::ThreadPool& pool) {
  rays_.resize(3, size());
  pixels_.resize(size());
  linalg::for_entries(size(), pool, [&](std::size_t i) {
    const auto s = static_cast<std::int64_t>(i);
    const auto& p = *undistorted[index(observation(s))];
    rays_.col(s) = Eigen::Vector3d(p[0], p[1], -1).normalized();
    pixels_[s] = pixels_per_radian(lens_of(problem, observation(s)), rays_.col(s));
  });
}

void Sightings::sort(const Problem& problem) {
  const auto key = [&](std::int32_t k) {
    return std::pair(problem.observation_point[index(k)], problem.observation_camera[index(k)]);
  };
  std::stable_sort(observation_.begin(), observation_.end(),
                   [&](std::int32_t x, std::int32_t y) { return key(x) < key(y); });
  observation_.erase(std::unique(observation_.begin(), observation_.end(),
                                 [&](std::int32_t x, std::int32_t y) { return key(x) == key(y); }),
                     observation_.end());
  repeated_ = problem.observation_count() - impossible_ - size_of(observation_);
  point_begin_.assign(index(problem.point_count() + 1), 0);
  image_begin_.assign(index(problem.camera_count() + 1), 0);
  for (const std::int32_t k : observation_) {
    point_.push_back(problem.observation_point[index(k)]);
    image_.push_back(problem.observation_camera[index(k)]);
    ++point_begin_[index(point_.back()) + 1];
    ++image_begin_[index(image_.back()) + 1];
  }
  std::partial_sum(point_begin_.begin(), point_begin_.end(), point_begin_.begin());
  std::partial_sum(image_begin_.begin(), image_begin_.end(), image_begin_.begin());
}

void Sightings::list_by_image() {
  by_image_.resize(image_.size());
  std::vector<std::int64_t> next(image_begin_.begin(), image_begin_.end() - 1);
  for (std::int64_t s = 0; s < size(); ++s) {
    by_image_[index(next[index(image(s))]++)] = static_cast<std::int32_t>(s);
  }
}

RayPairs Sightings::pairs(std::int32_t i, std::int32_t j) const {
  std::vector<std::pair<std::int32_t, std::int32_t>> both;
  const auto of_i = of_image(i), of_j = of_image(j);
  for (auto a = of_i.begin(), b = of_j.begin(); a != of_i.end() && b != of_j.end();) {
    const std::int32_t p = point(*a), q = point(*b);
    if (p == q) both.emplace_back(*a, *b);
    if (p <= q) ++a;
    if (q <= p) ++b;
  }
  const auto count = static_cast<Eigen::Index>(both.size());
  RayPairs result = {Eigen::Matrix3Xd(3, count), Eigen::Matrix3Xd(3, count), Eigen::VectorXd(count),
                     Eigen::VectorXd(count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto [a, b] = both[index(k)];
    result.a.col(k) = ray(a);
    result.b.col(k) = ray(b);
    result.pixels_a[k] = pixels(a);
    result.pixels_b[k] = pixels(b);
  }
  return result;
}

}  // namespace raybundle::init
