#include <raybundle/solver/init/point_agreement.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/models/alignment.h>
#include <raybundle/models/statistics.h>
#include <raybundle/solver/init/triangulation.h>

#include <algorithm>
#include <vector>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using linalg::index;

// The rays of points in the world.
class Rays {
 public:
  Rays(const Sightings& sightings, std::span<const std::uint8_t> images, const Problem& problem)
      : sightings_(sightings),
        images_(images),
        R_cw_(camera_rotations(problem)),
        centres_(camera_centres(problem)) {}

  std::vector<WorldRay> of_point(std::int64_t point) const {
    std::vector<WorldRay> result;
    const Sightings::Range track = sightings_.of_point(point);
    for (std::int64_t s = track.first; s < track.last; ++s) {
      const std::size_t image = index(sightings_.image(s));
      if (images_[image] == 0) continue;
      result.push_back({Eigen::Map<const Vector3d>(centres_.data() + 3 * image),
                        R_cw_[image].transpose() * sightings_.ray(s), sightings_.pixels(s)});
    }
    return result;
  }

 private:
  const Sightings& sightings_;
  std::span<const std::uint8_t> images_;
  std::vector<Matrix3d> R_cw_;
  std::vector<double> centres_;
};

}  // namespace

std::int64_t move_to_agreement(const Sightings& sightings, std::span<const std::uint8_t> images,
                               std::span<const std::uint8_t> points, double threshold,
                               Problem& problem, linalg::ThreadPool& pool) {
  const Rays rays(sightings, images, problem);
  const auto place = [&](std::int64_t p) {
    return Eigen::Map<Vector3d>(problem.points.data() + Problem::point_size * p);
  };
  const auto for_points = [&](auto&& visit) {
    linalg::parallel_for(pool, sightings.points(), 64, [&](std::int64_t p, std::int64_t last) {
      for (; p < last; ++p) {
        if (points[index(p)] != 0) visit(p, rays.of_point(p));
      }
    });
  };
  std::vector<double> worst(points.size(), 0);  // of the sightings of each
  for_points([&](std::int64_t p, const std::vector<WorldRay>& seen) {
    for (const WorldRay& ray : seen) {
      worst[index(p)] = std::max(worst[index(p)], pixels_off(ray, place(p)));
    }
  });
  const double scale = std::max(threshold, upper_median(std::move(worst)));
  std::vector<std::uint8_t> moved(points.size(), 0);
  for_points([&](std::int64_t p, const std::vector<WorldRay>& seen) {
    if (seen.size() < 2) return;
    const Vector3d before = place(p);
    place(p) = best_agreed(seen, before, scale);
    moved[index(p)] = place(p) == before ? 0 : 1;
  });
  return std::count(moved.begin(), moved.end(), 1);
}

}  // namespace raybundle::init
