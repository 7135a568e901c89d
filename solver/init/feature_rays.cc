#include <raybundle/solver/init/feature_rays.h>

#include <raybundle/linalg/block_layout.h>

#include <Eigen/LU>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using linalg::index;

// The different images among the terms of a ray.
struct Depends {
  std::array<std::int32_t, 3> image;
  int count;
};
Depends images_of(const FeatureRay& ray, const Feature& feature) {
  const bool twice = ray.image == feature.main || ray.image == feature.associate;
  return {{feature.main, feature.associate, ray.image}, twice ? 2 : 3};
}

// What a ray says of one image's position, in squared pixels for a move as far as the anchors are
// apart: N is that long times scale(), and only what is across v is seen.
Matrix3d information(const FeatureRay& ray, const Feature& feature, std::int32_t image) {
  Matrix3d J = Matrix3d::Zero();
  for (const auto& term : ray.terms(feature)) {
    if (term.image == image) J += term.coefficient;
  }
  const Matrix3d across = Matrix3d::Identity() - ray.v * ray.v.transpose();
  const double pixels = ray.pixels / std::max(feature.scale(), 1e-12);
  return pixels * pixels * J.transpose() * across * J;
}

// Whether no direction has less than a squared pixel: A - I is positive definite, by the signs
// of its leading minors.
bool is_told(const Matrix3d& A) {
  const Matrix3d B = A - Matrix3d::Identity();
  return B(0, 0) > 0 && B(0, 0) * B(1, 1) > B(0, 1) * B(1, 0) && B.determinant() > 0;
}

class Growth {
 public:
  Growth(std::int64_t images, std::span<const Feature> features, std::span<const FeatureRay> rays)
      : features_(features), rays_(rays), begin_(index(images + 1), 0) {
    for_terms([&](std::int32_t image, std::int64_t) { ++begin_[index(image) + 1]; });
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    of_image_.resize(index(begin_.back()));
    std::vector<std::int64_t> next(begin_.begin(), begin_.end() - 1);
    for_terms([&](std::int32_t image, std::int64_t ray) {
      of_image_[index(next[index(image)]++)] = ray;
    });
  }

  std::vector<std::uint8_t> grown_from(std::int32_t a, std::int32_t b) {
    const std::size_t images = begin_.size() - 1;
    inside_.assign(images, 0);
    known_.assign(images, Matrix3d::Zero());
    missing_.clear();
    for (const FeatureRay& ray : rays_) missing_.push_back(depends(ray).count);
    inside_[index(a)] = inside_[index(b)] = 1;
    queue_ = {a, b};
    for (std::size_t at = 0; at < queue_.size(); ++at) spread(queue_[at]);
    return inside_;
  }

 private:
  Depends depends(const FeatureRay& ray) const {
    return images_of(ray, features_[index(ray.feature)]);
  }

  template <class Visit>
  void for_terms(Visit&& visit) const {
    for (std::size_t k = 0; k < rays_.size(); ++k) {
      const Depends of = depends(rays_[k]);
      for (int i = 0; i < of.count; ++i) {
        visit(of.image[index(i)], static_cast<std::int64_t>(k));
      }
    }
  }

  // Rays of an image of the set that now wait for one other image alone tell of it.
  void spread(std::int32_t image) {
    for (std::int64_t k = begin_[index(image)]; k < begin_[index(image) + 1]; ++k) {
      const auto at = index(of_image_[index(k)]);
      if (--missing_[at] != 1) continue;
      const FeatureRay& ray = rays_[at];
      const Depends of = depends(ray);
      for (int i = 0; i < of.count; ++i) {
        const std::int32_t other = of.image[index(i)];
        if (inside_[index(other)] != 0) continue;
        known_[index(other)] += information(ray, features_[index(ray.feature)], other);
        if (!is_told(known_[index(other)])) continue;
        inside_[index(other)] = 1;
        queue_.push_back(other);
      }
    }
  }

  std::span<const Feature> features_;
  std::span<const FeatureRay> rays_;
  std::vector<std::int64_t> begin_, of_image_;  // rays of an image
  std::vector<std::uint8_t> inside_;
  std::vector<Matrix3d> known_;
  std::vector<int> missing_;
  std::vector<std::int32_t> queue_;
};

using Pair = std::pair<std::int32_t, std::int32_t>;

// Pairs of anchors, those of most features first; features of which the rays differ from parallel
// ones by less than two pixels do not count.
std::vector<Pair> anchor_pairs(std::span<const Feature> features,
                               std::span<const FeatureRay> rays) {
  constexpr double least_parallax = 2;
  std::map<Pair, std::int64_t> found;
  for (const FeatureRay& ray : rays) {
    const Feature& of = features[index(ray.feature)];
    if (ray.image == of.main && ray.pixels * of.sin_theta > least_parallax) {
      ++found[{of.main, of.associate}];
    }
  }
  std::vector<Pair> result;
  result.reserve(found.size());
  for (const auto& each : found) result.push_back(each.first);
  std::stable_sort(result.begin(), result.end(),
                   [&](const Pair& x, const Pair& y) { return found[x] > found[y]; });
  return result;
}

}  // namespace

std::vector<FeatureRay> feature_rays(const Sightings& sightings, std::span<const Feature> features,
                                     const std::vector<Matrix3d>& R_cw,
                                     std::span<const std::uint8_t> marked) {
  std::vector<FeatureRay> result;
  for (std::size_t k = 0; k < features.size(); ++k) {
    const Sightings::Range track = sightings.of_point(features[k].point);
    for (std::int64_t s = track.first; s < track.last; ++s) {
      const std::int32_t image = sightings.image(s);
      if (marked[index(image)] == 0) continue;
      result.push_back({static_cast<std::int32_t>(k), image, sightings.pixels(s),
                        world_ray(sightings, R_cw, s)});
    }
  }
  return result;
}

// What grows from a pair inside a set stays inside it, so that such pairs need not be tried.
std::vector<std::uint8_t> determined_images(std::int64_t images, std::span<const Feature> features,
                                            std::span<const FeatureRay> rays) {
  Growth growth(images, features, rays);
  std::vector<std::uint8_t> best(index(images), 0);
  std::vector<std::vector<std::uint8_t>> tried;
  std::int64_t most = 0;
  for (const auto& [a, b] : anchor_pairs(features, rays)) {
    const bool is_inside = std::any_of(
        tried.begin(), tried.end(),
        [&, a = a, b = b](const auto& set) { return set[index(a)] != 0 && set[index(b)] != 0; });
    if (is_inside) continue;
    tried.push_back(growth.grown_from(a, b));
    const auto size = std::count(tried.back().begin(), tried.back().end(), 1);
    if (size > most) most = size, best = tried.back();
    if (2 * most >= images) break;
  }
  return best;
}

}  // namespace raybundle::init
