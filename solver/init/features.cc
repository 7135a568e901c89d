#include <raybundle/solver/init/features.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/models/anchors.h>
#include <raybundle/models/point_model.h>
#include <raybundle/models/rotation.h>
#include <raybundle/solver/init/epipolar.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using linalg::index;

// Edges with a translation, by their images.
class Translations {
 public:
  explicit Translations(const ViewGraph& graph)
      : begin_(index(graph.images + 1), 0), graph_(graph) {
    for (std::size_t k = 0; k < graph.edges.size(); ++k) {  // ascending by i, then j
      if (graph.edges[k].pose.t.isZero(0)) continue;
      edges_.push_back(static_cast<std::int64_t>(k));
      ++begin_[index(graph.edges[k].i) + 1];
    }
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  }

  const ViewEdge* find(std::int32_t i, std::int32_t j) const {
    const auto first = edges_.begin() + begin_[index(i)],
               last = edges_.begin() + begin_[index(i) + 1];
    const auto found = std::lower_bound(first, last, j, [&](std::int64_t k, std::int32_t wanted) {
      return graph_.edges[index(k)].j < wanted;
    });
    if (found == last || graph_.edges[index(*found)].j != j) return nullptr;
    return &graph_.edges[index(*found)];
  }

 private:
  std::vector<std::int64_t> begin_, edges_;
  const ViewGraph& graph_;
};

struct Observer {
  std::int64_t sighting;
  Vector3d ray;  // in the world
};

bool agrees(const Sightings& sightings, const ViewEdge& edge, std::int64_t a, std::int64_t b,
            double threshold) {
  const RayPairs pair = {sightings.ray(a), sightings.ray(b),
                         Eigen::VectorXd::Constant(1, sightings.pixels(a)),
                         Eigen::VectorXd::Constant(1, sightings.pixels(b))};
  return squared_epipolar_error(essential_matrix(edge.pose), pair, 0) < threshold * threshold;
}

// A rotation by which -u, the direction from P_m to P_a, comes to w, and what else N needs; u, w
// and w_a are directions in the world [Liu18, Eq. 11].
Feature feature_of(std::int32_t point, const Vector3d& u, const Vector3d& w, const Vector3d& w_a) {
  Feature result;
  result.point = point;
  const double theta = std::atan2(w.cross(w_a).norm(), w.dot(w_a));
  const double alpha = std::atan2(u.cross(w).norm(), u.dot(w));
  Vector3d n_z = w.cross(u);  // -u x w
  if (n_z.norm() < 1e-12) {
    Vector3d other;
    tangent_basis(w.data(), n_z.data(), other.data());
  }
  result.sin_theta = std::sin(theta);
  result.G = std::sin(alpha - theta) * so3::exp((std::numbers::pi - alpha) * n_z.normalized());
  return result;
}

class Chooser {
 public:
  Chooser(const Sightings& sightings, const ViewGraph& graph, const std::vector<Matrix3d>& R_cw,
          std::span<const std::uint8_t> known, double threshold)
      : sightings_(sightings),
        translations_(graph),
        R_cw_(R_cw),
        known_(known),
        threshold_(threshold) {}

  std::optional<Feature> choose(std::int32_t point) const {
    const std::vector<Observer> observers = compared_observers(point);
    const ViewEdge* best = nullptr;
    const Observer *main = nullptr, *associate = nullptr;
    double most = -3;
    for (std::size_t i = 0; i < observers.size(); ++i) {
      for (std::size_t j = i + 1; j < observers.size(); ++j) {
        const Observer &a = observers[i], &b = observers[j];
        const double of_pair = anchor_quality(a.ray, b.ray);
        if (of_pair <= most) continue;
        const ViewEdge* edge =
            translations_.find(sightings_.image(a.sighting), sightings_.image(b.sighting));
        if (!edge || !agrees(sightings_, *edge, a.sighting, b.sighting, threshold_)) continue;
        most = of_pair;
        best = edge, main = &a, associate = &b;
      }
    }
    if (!best) return {};
    // t = R_cw_a (P_m - P_a), with m = i and a = j.
    const Vector3d u = R_cw_[index(best->j)].transpose() * best->pose.t;
    Feature result = feature_of(point, u, main->ray, associate->ray);
    result.main = best->i;
    result.associate = best->j;
    return result;
  }

 private:
  std::vector<Observer> compared_observers(std::int32_t point) const {
    const Sightings::Range track = sightings_.of_point(point);
    std::vector<std::int64_t> all;
    for (std::int64_t s = track.first; s < track.last; ++s) {
      if (known_[index(sightings_.image(s))] != 0) all.push_back(s);
    }
    std::vector<Observer> result;
    const auto length = static_cast<std::int64_t>(all.size());
    const std::int64_t count = std::min(length, most_compared_anchors);
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int64_t s = all[index(count > 1 ? i * (length - 1) / (count - 1) : 0)];
      result.push_back({s, world_ray(sightings_, R_cw_, s)});
    }
    return result;
  }

  const Sightings& sightings_;
  Translations translations_;
  const std::vector<Matrix3d>& R_cw_;
  std::span<const std::uint8_t> known_;
  double threshold_;
};

}  // namespace

Vector3d world_ray(const Sightings& sightings, const std::vector<Matrix3d>& R_cw,
                   std::int64_t sighting) {
  return R_cw[index(sightings.image(sighting))].transpose() * sightings.ray(sighting);
}

std::vector<Feature> features(const Sightings& sightings, const ViewGraph& graph,
                              const std::vector<Matrix3d>& R_cw,
                              std::span<const std::uint8_t> known, double threshold,
                              linalg::ThreadPool& pool) {
  const Chooser chooser(sightings, graph, R_cw, known, threshold);
  std::vector<std::optional<Feature>> found(index(sightings.points()));
  linalg::parallel_for(pool, sightings.points(), 64, [&](std::int64_t first, std::int64_t last) {
    for (; first < last; ++first)
      found[index(first)] = chooser.choose(static_cast<std::int32_t>(first));
  });
  std::vector<Feature> result;
  for (const auto& feature : found) {
    if (feature) result.push_back(*feature);
  }
  return result;
}

}  // namespace raybundle::init
