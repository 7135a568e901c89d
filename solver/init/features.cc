#include <raybundle/solver/init/features.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/models/anchors.h>
#include <raybundle/models/point_model.h>
#include <raybundle/models/rotation.h>
#include <raybundle/solver/init/epipolar.h>
#include <raybundle/solver/init/simple_motion.h>

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

// Edges by their images.
class Edges {
 public:
  explicit Edges(const ViewGraph& graph) : begin_(index(graph.images + 1), 0), graph_(graph) {
    essential_.reserve(graph.edges.size());
    for (const ViewEdge& edge : graph.edges) {
      ++begin_[index(edge.i) + 1];
      essential_.push_back(essential_matrix(edge.alone));
    }
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  }

  const ViewEdge* find(std::int32_t i, std::int32_t j) const {
    const auto first = graph_.edges.begin() + begin_[index(i)],
               last = graph_.edges.begin() + begin_[index(i) + 1];
    const auto found = std::lower_bound(
        first, last, j, [](const ViewEdge& edge, std::int32_t wanted) { return edge.j < wanted; });
    return found == last || found->j != j ? nullptr : &*found;
  }

  const Matrix3d& essential(const ViewEdge& edge) const {
    return essential_[static_cast<std::size_t>(&edge - graph_.edges.data())];
  }

 private:
  std::vector<std::int64_t> begin_;
  std::vector<Matrix3d> essential_;
  const ViewGraph& graph_;  // ascending by i, then j
};

struct Observer {
  std::int64_t sighting;
  Vector3d ray;                           // in the world
  std::int32_t compared = 0, agreed = 0;  // with others

  double share() const { return compared > 0 ? static_cast<double>(agreed) / compared : 0; }
};

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
      : sightings_(sightings), edges_(graph), R_cw_(R_cw), known_(known), threshold_(threshold) {}

  // Marks the sightings that agree with no other.
  std::optional<Feature> choose(std::int32_t point, std::vector<std::uint8_t>& disagreeing) const {
    std::vector<Observer> observers = compared_observers(point);
    const std::vector<Agreement> agreements = agreements_of(observers);
    double most = 0;
    for (const Observer& each : observers) most = std::max(most, each.share());
    const auto stands_alone = [most](const Observer& each) {
      return each.compared > 0 && each.share() <= 0.5 * most;
    };
    for (const Observer& each : observers) {
      if (stands_alone(each)) disagreeing[index(each.sighting)] = 1;
    }
    const Agreement* best = nullptr;
    for (const Agreement& each : agreements) {
      if (stands_alone(observers[each.i]) || stands_alone(observers[each.j])) continue;
      if (!best || each.quality > best->quality) best = &each;
    }
    if (!best) return {};
    const ViewEdge& edge = *best->edge;
    // t = R_cw_a (P_m - P_a), with m = i and a = j.
    const Vector3d u = R_cw_[index(edge.j)].transpose() * edge.pose.t;
    Feature result = feature_of(point, u, observers[best->i].ray, observers[best->j].ray);
    result.main = edge.i;
    result.associate = edge.j;
    return result;
  }

 private:
  // Two observers whose rays meet in front of both, and the edge between them has a translation.
  struct Agreement {
    std::size_t i, j;
    const ViewEdge* edge;
    double quality;
  };

  std::vector<Agreement> agreements_of(std::vector<Observer>& observers) const {
    std::vector<Agreement> result;
    for (std::size_t i = 0; i < observers.size(); ++i) {
      for (std::size_t j = i + 1; j < observers.size(); ++j) {
        Observer &a = observers[i], &b = observers[j];
        const ViewEdge* edge =
            edges_.find(sightings_.image(a.sighting), sightings_.image(b.sighting));
        if (!edge) continue;
        ++a.compared, ++b.compared;
        if (!agree(*edge, a.sighting, b.sighting)) continue;
        ++a.agreed, ++b.agreed;
        if (edge->pose.t.isZero(0)) continue;
        result.push_back({i, j, edge, anchor_quality(a.ray, b.ray)});
      }
    }
    return result;
  }

  // Where an edge has no translation hardly a point moves by more than the threshold.
  bool agree(const ViewEdge& edge, std::int64_t a, std::int64_t b) const {
    constexpr double least_parallax = 1, most_parallax = 2;  // pixels, thresholds
    const RayPair pair = {sightings_.ray(a), sightings_.ray(b), sightings_.pixels(a),
                          sightings_.pixels(b)};
    if (edge.alone.t.isZero(0)) {
      return std::sqrt(squared_error(edge.alone.R, pair)) < most_parallax * threshold_;
    }
    return epipolar_error(edges_.essential(edge), pair).squared() < threshold_ * threshold_ &&
           side_of(edge.alone, pair, least_parallax) != Side::behind;
  }

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
  Edges edges_;
  const std::vector<Matrix3d>& R_cw_;
  std::span<const std::uint8_t> known_;
  double threshold_;
};

}  // namespace

Vector3d world_ray(const Sightings& sightings, const std::vector<Matrix3d>& R_cw,
                   std::int64_t sighting) {
  return R_cw[index(sightings.image(sighting))].transpose() * sightings.ray(sighting);
}

Features features(const Sightings& sightings, const ViewGraph& graph,
                  const std::vector<Matrix3d>& R_cw, std::span<const std::uint8_t> known,
                  double threshold, linalg::ThreadPool& pool) {
  const Chooser chooser(sightings, graph, R_cw, known, threshold);
  Features result;
  result.disagreeing.assign(index(sightings.size()), 0);
  std::vector<std::optional<Feature>> found(index(sightings.points()));
  linalg::parallel_for(pool, sightings.points(), 64, [&](std::int64_t first, std::int64_t last) {
    for (; first < last; ++first) {
      found[index(first)] = chooser.choose(static_cast<std::int32_t>(first), result.disagreeing);
    }
  });
  for (const auto& feature : found) {
    if (feature) result.all.push_back(*feature);
  }
  return result;
}

}  // namespace raybundle::init
