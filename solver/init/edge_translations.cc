#include <raybundle/solver/init/edge_translations.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/solver/init/epipolar.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <optional>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The t with the least weighted sum of (t . (R a x b))^2, weights following from the last t, or 1
// where it is 0.
Vector3d best_direction(const RelativePose& start, const RayPairs& pairs, double scale) {
  constexpr int rounds = 10;
  RelativePose pose = start;
  for (int round = 0; round < rounds; ++round) {
    const Matrix3d E = essential_matrix(pose);
    const bool blind = pose.t.isZero(0);
    Matrix3d sum = Matrix3d::Zero();
    for (std::int64_t i = 0; i < pairs.size(); ++i) {
      const RayPair pair = pairs.pair(i);
      const Vector3d normal = (pose.R * pair.a).cross(pair.b);
      const EpipolarError error = epipolar_error(E, pair);
      if (!blind && !(error.variance > 0)) continue;
      const double weight =
          blind ? 1 : 1 / (error.variance * (1 + error.squared() / (scale * scale)));
      sum += weight * normal * normal.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(sum);
    const Vector3d t = eigen.eigenvectors().col(0);
    pose.t = t.dot(pose.t) < 0 ? Vector3d(-t) : t;
  }
  return pose.t;
}

// Half of the inliers with a parallax of less than this many pixels tell no direction.
constexpr double least_parallax = 1;

bool has_parallax(const RelativePose& pose, const RayPairs& pairs,
                  std::span<const std::int32_t> which) {
  const Sides seen = sides(pose, pairs, which, least_parallax);
  return 2 * (seen.front + seen.behind) > static_cast<std::int64_t>(which.size());
}

ViewEdge anew(const Sightings& sightings, ViewEdge edge, const Matrix3d& R_ji,
              const RelativePoseOptions& options) {
  const RayPairs pairs = sightings.pairs(edge.i, edge.j);
  edge.pose.R = R_ji;
  if (edge.kind == PairKind::rotation) return edge;
  edge.pose.t = best_direction(edge.pose, pairs, 0.5 * options.threshold);
  const Matrix3d E = essential_matrix(edge.pose);
  const auto inliers = inliers_of(pairs.size(), options.threshold, [&](std::int64_t i) {
    return squared_epipolar_error(E, pairs, i);
  });
  edge.inliers = static_cast<std::int64_t>(inliers.size());
  const RelativePose back = {edge.pose.R, -edge.pose.t};
  if (sides(back, pairs, inliers, least_parallax).front >
      sides(edge.pose, pairs, inliers, least_parallax).front) {
    edge.pose = back;
  }
  const bool told = edge.inliers >= options.min_inliers && has_parallax(edge.pose, pairs, inliers);
  if (!told) edge.pose.t.setZero();
  if (edge.alone.t.isZero(0)) edge.alone = edge.pose;
  return edge;
}

}  // namespace

ViewGraph with_rotations(const Sightings& sightings, const ViewGraph& graph,
                         const AveragedRotations& rotations, const RelativePoseOptions& options,
                         linalg::ThreadPool& pool) {
  const auto count = static_cast<std::int64_t>(graph.edges.size());
  std::vector<std::optional<ViewEdge>> edges(graph.edges.size());
  pool.run(count, [&](std::int64_t k) {
    const auto at = linalg::index(k);
    const ViewEdge& edge = graph.edges[at];
    const auto i = linalg::index(edge.i), j = linalg::index(edge.j);
    if (rotations.pruned[at] != 0 || rotations.known[i] == 0 || rotations.known[j] == 0) return;
    edges[at] = anew(sightings, edge, rotations.R_cw[j] * rotations.R_cw[i].transpose(), options);
  });
  ViewGraph result = {graph.images, {}, false};
  for (const auto& edge : edges) {
    if (edge) result.edges.push_back(*edge);
  }
  return result;
}

}  // namespace raybundle::init
