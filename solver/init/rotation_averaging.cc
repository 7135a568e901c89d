#include <raybundle/solver/init/rotation_averaging.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/models/rotation.h>
#include <raybundle/solver/init/pose_graph_system.h>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using linalg::index;
using Rotations = std::vector<Matrix3d>;

constexpr double widest_scale = 1;  // radian

std::vector<WeightedEdge> weighted(std::span<const RelativeRotation> edges) {
  std::vector<WeightedEdge> result;
  result.reserve(edges.size());
  for (const RelativeRotation& edge : edges) result.push_back({edge.i, edge.j, edge.weight});
  return result;
}

// R_j^T R_ji R_i as a rotation vector, in the frame of the world.
Vector3d disagreement(const RelativeRotation& edge, const Rotations& R) {
  return so3::log(Matrix3d(R[index(edge.j)].transpose() * edge.R_ji * R[index(edge.i)]));
}

std::vector<double> angles_of(std::span<const RelativeRotation> edges, const Rotations& R) {
  std::vector<double> result;
  result.reserve(edges.size());
  for (const RelativeRotation& edge : edges) result.push_back(disagreement(edge, R).norm());
  return result;
}

AngleStatistics statistics_of(std::vector<double> angles) {
  if (angles.empty()) return {};
  std::sort(angles.begin(), angles.end());
  const std::size_t n = angles.size();
  return {std::accumulate(angles.begin(), angles.end(), 0.0) / static_cast<double>(n),
          angles[n / 2], angles[std::min(n - 1, 9 * n / 10)], angles.back()};
}

Matrix3d nearest_rotation(const Matrix3d& M) {
  const Eigen::JacobiSVD<Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

// A connected graph, with nodes 0 .. nodes - 1.
class ConnectedRotations {
 public:
  ConnectedRotations(std::int64_t nodes, std::vector<RelativeRotation> edges, std::int32_t root,
                     linalg::ThreadPool& pool)
      : nodes_(nodes), edges_(std::move(edges)), root_(root), system_(nodes, couples(), pool) {}

  Rotations along_tree() const {
    Rotations R(index(nodes_), Matrix3d::Identity());
    const auto weights = weighted(edges_);
    for (const TreeEdge& step : maximum_spanning_tree(nodes_, weights, root_)) {
      const RelativeRotation& edge = edges_[index(step.edge)];
      const Matrix3d R_cp = edge.i == step.parent ? edge.R_ji : Matrix3d(edge.R_ji.transpose());
      R[index(step.child)] = R_cp * R[index(step.parent)];
    }
    return R;
  }

  // Minimises the weighted sum of |R_j - R_ji R_i|^2 over matrices, then takes the nearest
  // rotations [Carlone15, III-B].
  Rotations chordal() {
    Eigen::MatrixXd X = Eigen::MatrixXd::Zero(3 * nodes_, 3);
    system_.set_zero();
    for (const RelativeRotation& edge : edges_) {
      const Matrix3d W = edge.weight * Matrix3d::Identity();
      system_.add(edge.i, edge.i, W);
      system_.add(edge.j, edge.j, W);
      system_.add(edge.i, edge.j, -edge.weight * edge.R_ji.transpose());
      if (edge.i == root_) X.middleRows<3>(3 * edge.j) += edge.weight * edge.R_ji;
      if (edge.j == root_) X.middleRows<3>(3 * edge.i) += edge.weight * edge.R_ji.transpose();
    }
    X.middleRows<3>(3 * root_).setIdentity();
    system_.hold(root_);
    if (!system_.factor()) return along_tree();
    system_.solve(X);
    Rotations R;
    R.reserve(index(nodes_));
    for (std::int64_t i = 0; i < nodes_; ++i) {
      R.push_back(nearest_rotation(X.middleRows<3>(3 * i)));
    }
    return R;
  }

  // Returns the iterations. Disagreements count as squares below a scale, which begins so wide that
  // all do, and narrows to their median: from a start that agrees with a few wrong edges at the
  // price of many right ones, a narrow one would never get away.
  int refine(Rotations& R, int most_iterations, double widest) {
    constexpr double smallest_scale = 1e-7, smallest_step = 1e-5, narrowing = 0.7;
    double scale = widest;
    int iteration = 0;
    while (iteration < most_iterations) {
      ++iteration;
      const double median = std::max(smallest_scale, statistics_of(angles_of(edges_, R)).median);
      const bool narrow = scale <= median;
      if (step(R, std::max(scale, median)) < smallest_step && narrow) break;
      scale *= narrowing;
    }
    return iteration;
  }

  // What is to be small: large disagreements count little.
  double robust_sum(const Rotations& R) const {
    double sum = 0;
    for (const double angle : angles_of(edges_, R)) sum += std::sqrt(angle);
    return sum;
  }

  std::vector<double> angles(const Rotations& R) const { return angles_of(edges_, R); }

 private:
  std::vector<PoseGraphSystem::Couple> couples() const {
    std::vector<PoseGraphSystem::Couple> result;
    result.reserve(edges_.size());
    for (const RelativeRotation& edge : edges_) result.emplace_back(edge.i, edge.j);
    return result;
  }

  // R_i <- R_i Exp(w_i), where log(R_j^T R_ji R_i) becomes its sum with w_i - w_j to first order;
  // returns the largest turn.
  double step(Rotations& R, double floor) {
    Eigen::MatrixXd w = Eigen::MatrixXd::Zero(3 * nodes_, 1);
    system_.set_zero();
    for (const RelativeRotation& edge : edges_) {
      const Vector3d r = disagreement(edge, R);
      const double weight = std::pow(1 + r.squaredNorm() / (floor * floor), -0.75);
      const Matrix3d W = weight * Matrix3d::Identity();
      system_.add(edge.i, edge.i, W);
      system_.add(edge.j, edge.j, W);
      system_.add(edge.i, edge.j, -W);
      w.middleRows<3>(3 * edge.i) -= weight * r;
      w.middleRows<3>(3 * edge.j) += weight * r;
    }
    w.middleRows<3>(3 * root_).setZero();
    system_.hold(root_);
    if (!system_.factor()) return 0;
    system_.solve(w);
    double largest = 0;
    for (std::int64_t i = 0; i < nodes_; ++i) {
      const Vector3d turn = w.middleRows<3>(3 * i);
      R[index(i)] = nearest_rotation(R[index(i)] * so3::exp(turn));
      largest = std::max(largest, turn.norm());
    }
    return largest;
  }

  std::int64_t nodes_;
  std::vector<RelativeRotation> edges_;
  std::int32_t root_;
  PoseGraphSystem system_;
};

// The largest component of those edges that are not pruned, with numbers of its own.
struct Core {
  std::vector<std::int32_t> image;  // of a node
  std::vector<std::int32_t> node;   // of an image; -1: not in it
  std::vector<std::int64_t> edge;   // kept: their places in the whole list
  std::vector<RelativeRotation> edges;

  Core(std::int64_t images, std::span<const RelativeRotation> all,
       const std::vector<std::uint8_t>& pruned)
      : node(index(images), -1) {
    std::vector<WeightedEdge> left;
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (pruned[k] == 0) left.push_back({all[k].i, all[k].j, all[k].weight});
    }
    const Components parts = components(images, left);
    for (std::int32_t i = 0; i < images; ++i) {
      if (!parts.in_largest(i)) continue;
      node[index(i)] = static_cast<std::int32_t>(image.size());
      image.push_back(i);
    }
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (pruned[k] != 0 || node[index(all[k].i)] < 0 || node[index(all[k].j)] < 0) continue;
      edge.push_back(static_cast<std::int64_t>(k));
      edges.push_back({node[index(all[k].i)], node[index(all[k].j)], all[k].R_ji, all[k].weight});
    }
  }

  std::int64_t nodes() const { return static_cast<std::int64_t>(image.size()); }

  // The node whose edges weigh most.
  std::int32_t heaviest() const {
    std::vector<double> weight(image.size(), 0);
    for (const RelativeRotation& each : edges) {
      weight[index(each.i)] += each.weight;
      weight[index(each.j)] += each.weight;
    }
    return static_cast<std::int32_t>(std::max_element(weight.begin(), weight.end()) -
                                     weight.begin());
  }
};

void check(std::int64_t images, std::span<const RelativeRotation> edges) {
  for (const RelativeRotation& edge : edges) {
    const bool legal = edge.i >= 0 && edge.j >= 0 && edge.i < images && edge.j < images;
    if (!legal || edge.i == edge.j) {
      throw std::invalid_argument("an edge between images " + std::to_string(edge.i) + " and " +
                                  std::to_string(edge.j) + " of " + std::to_string(images));
    }
  }
}

// Of every image of the core, from both starts; marks the edges that disagree.
Rotations average_all(const Core& core, const RotationOptions& options, linalg::ThreadPool& pool,
                      AveragedRotations& result) {
  const std::int32_t root = core.heaviest();
  result.root = core.image[index(root)];
  ConnectedRotations graph(core.nodes(), core.edges, root, pool);
  Rotations R = graph.chordal(), tree = graph.along_tree();
  result.chordal = statistics_of(graph.angles(R));
  result.tree = statistics_of(graph.angles(tree));
  result.iterations = graph.refine(R, options.most_iterations, widest_scale) +
                      graph.refine(tree, options.most_iterations, widest_scale);
  if (graph.robust_sum(tree) < graph.robust_sum(R)) R.swap(tree);
  const std::vector<double> angles = graph.angles(R);
  result.before = statistics_of(angles);
  for (std::size_t k = 0; k < angles.size(); ++k) {
    result.pruned[index(core.edge[k])] = angles[k] > options.prune ? 1 : 0;
  }
  return R;
}

// The same of what is left, from rotations nearby; writes them into the result.
void average_rest(const Core& core, Rotations R, const RotationOptions& options,
                  linalg::ThreadPool& pool, AveragedRotations& result) {
  const std::int32_t before = core.node[index(result.root)];
  const std::int32_t root = before >= 0 ? before : core.heaviest();
  result.root = core.image[index(root)];
  ConnectedRotations graph(core.nodes(), core.edges, root, pool);
  result.iterations += graph.refine(R, options.most_iterations, 0);
  result.after = statistics_of(graph.angles(R));
  const Matrix3d R_wr = R[index(root)].transpose();
  for (std::size_t node = 0; node < R.size(); ++node) {
    result.R_cw[index(core.image[node])] = R[node] * R_wr;
    result.known[index(core.image[node])] = 1;
  }
}

}  // namespace

AveragedRotations average_rotations(std::int64_t images, std::span<const RelativeRotation> edges,
                                    const RotationOptions& options, linalg::ThreadPool& pool) {
  check(images, edges);
  AveragedRotations result;
  result.R_cw.assign(index(images), Matrix3d::Identity());
  result.known.assign(index(images), 0);
  result.angle.assign(edges.size(), std::numeric_limits<double>::quiet_NaN());
  result.pruned.assign(edges.size(), 0);
  if (images == 0) return result;

  const Core all(images, edges, result.pruned);
  const Rotations R = average_all(all, options, pool, result);
  const Core left(images, edges, result.pruned);
  Rotations kept;
  kept.reserve(left.image.size());
  for (const std::int32_t image : left.image) kept.push_back(R[index(all.node[index(image)])]);
  average_rest(left, std::move(kept), options, pool, result);
  for (std::size_t k = 0; k < edges.size(); ++k) {
    if (result.known[index(edges[k].i)] == 0 || result.known[index(edges[k].j)] == 0) continue;
    result.angle[k] = disagreement(edges[k], result.R_cw).norm();
  }
  return result;
}

}  // namespace raybundle::init
