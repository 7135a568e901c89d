#include <raybundle/solver/init/positions_linear.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/solver/init/feature_rays.h>
#include <raybundle/solver/init/position_programme.h>

#include <algorithm>
#include <utility>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using linalg::index;

// Images with numbers of their own, and the features and rays that depend on these alone.
struct Part {
  std::vector<std::int32_t> image;  // of a node
  std::vector<std::int32_t> node;   // of an image; -1
  std::vector<Feature> features;
  std::vector<FeatureRay> rays;

  Part(std::span<const std::uint8_t> marked, std::span<const Feature> all_features,
       std::span<const FeatureRay> all_rays)
      : node(marked.size(), -1) {
    for (std::size_t i = 0; i < marked.size(); ++i) {
      if (marked[i] == 0) continue;
      node[i] = static_cast<std::int32_t>(image.size());
      image.push_back(static_cast<std::int32_t>(i));
    }
    std::vector<std::int32_t> number(all_features.size(), -1);
    for (std::size_t k = 0; k < all_features.size(); ++k) {
      Feature each = all_features[k];
      each.main = node[index(each.main)];
      each.associate = node[index(each.associate)];
      if (each.main < 0 || each.associate < 0) continue;
      number[k] = static_cast<std::int32_t>(features.size());
      features.push_back(each);
    }
    for (FeatureRay ray : all_rays) {
      ray.feature = number[index(ray.feature)];
      ray.image = node[index(ray.image)];
      if (ray.feature >= 0 && ray.image >= 0) rays.push_back(ray);
    }
  }
};

}  // namespace

LinearPositions linear_positions(const Sightings& sightings, std::span<const Feature> features,
                                 const std::vector<Matrix3d>& R_cw,
                                 std::span<const std::uint8_t> known, std::int32_t root,
                                 const LinearPositionOptions& options, linalg::ThreadPool& pool) {
  LinearPositions result;
  result.P.assign(index(sightings.images()), Vector3d::Zero());
  result.known.assign(index(sightings.images()), 0);
  const auto rays = feature_rays(sightings, features, R_cw, known);
  Part part(determined_images(sightings.images(), features, rays), features, rays);
  result.rays = static_cast<std::int64_t>(part.rays.size());
  if (part.rays.empty()) return result;

  PositionProgramme programme(static_cast<std::int64_t>(part.image.size()),
                              std::max(part.node[index(root)], 0), std::move(part.features),
                              std::move(part.rays), pool);
  VectorXd x;
  for (; result.rounds < options.rounds; ++result.rounds) {
    if (result.rounds > 0) programme.reweight(x, options.scale);
    if (!programme.solve(x)) break;
    if (result.rounds == 0) result.rays_behind = (programme.depths(x).array() < 0).count();
    const auto steps = programme.constrain(x, options.admm_steps);
    result.admm_steps += steps.count;
    result.converged = result.converged && steps.converged;
  }
  if (result.rounds == 0) return result;
  for (std::size_t node = 0; node < part.image.size(); ++node) {
    result.P[index(part.image[node])] = x.segment<3>(3 * static_cast<std::int64_t>(node));
    result.known[index(part.image[node])] = 1;
  }
  return result;
}

}  // namespace raybundle::init
