#pragma once

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/problem.h>
#include <raybundle/solver/init/ray_pairs.h>

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace raybundle::init {

/// What the images of a problem saw of its points, by its lenses and observations alone: one
/// sighting for each observation, sorted by point, then image, of equal ones the first.
class Sightings {
 public:
  /// Throws InputError when the problem
  /// is inconsistent.
  Sightings(const Problem& problem, linalg::ThreadPool& pool);

  std::int64_t images() const { return static_cast<std::int64_t>(image_begin_.size()) - 1; }
  std::int64_t points() const { return static_cast<std::int64_t>(point_begin_.size()) - 1; }
  std::int64_t size() const { return static_cast<std::int64_t>(image_.size()); }

  /// Observations left out: those that their lens cannot have made, and those of a point that the
  /// image has already.
  std::int64_t impossible() const { return impossible_; }
  std::int64_t repeated() const { return repeated_; }

  /// Of a sighting.
  std::int32_t image(std::int64_t s) const { return image_[static_cast<std::size_t>(s)]; }
  std::int32_t point(std::int64_t s) const { return point_[static_cast<std::size_t>(s)]; }
  std::int32_t observation(std::int64_t s) const {
    return observation_[static_cast<std::size_t>(s)];
  }
  Eigen::Vector3d ray(std::int64_t s) const { return rays_.col(s); }  ///< in the camera's frame
  double pixels(std::int64_t s) const { return pixels_[s]; }          ///< per radian, there

  /// Sightings of a point: [first, last), ascending by image.
  struct Range {
    std::int64_t first, last;
    std::int64_t size() const { return last - first; }
  };
  Range of_point(std::int64_t p) const {
    return {point_begin_[static_cast<std::size_t>(p)],
            point_begin_[static_cast<std::size_t>(p) + 1]};
  }
  /// Sightings of an image, ascending by point.
  std::span<const std::int32_t> of_image(std::int64_t i) const {
    const auto at = static_cast<std::size_t>(i);
    return {by_image_.data() + image_begin_[at], by_image_.data() + image_begin_[at + 1]};
  }

  /// The rays of two images to the points that both saw, ascending by point.
  RayPairs pairs(std::int32_t i, std::int32_t j) const;

 private:
  using Pixel = std::optional<std::array<double, 2>>;

  void sort(const Problem& problem);
  void take_rays(const Problem& problem, std::span<const Pixel> undistorted,
                 linalg::ThreadPool& pool);
  void list_by_image();

  std::int64_t impossible_ = 0, repeated_ = 0;
  std::vector<std::int32_t> observation_;  // of a sighting
  std::vector<std::int32_t> image_, point_;
  std::vector<std::int64_t> point_begin_, image_begin_;
  std::vector<std::int32_t> by_image_;
  Eigen::Matrix3Xd rays_;
  Eigen::VectorXd pixels_;
};

}  // namespace raybundle::init
