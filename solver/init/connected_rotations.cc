#include <raybundle/solver/init/connected_rotations.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/models/rotation.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using linalg::index;

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

}  // namespace

double angle_of(const RelativeRotation& edge, const Rotations& R) {
  return disagreement(edge, R).norm();
}

std::vector<double> angles_of(std::span<const RelativeRotation> edges, const Rotations& R) {
  std::vector<double> result;
  result.reserve(edges.size());
  for (const RelativeRotation& edge : edges) result.push_back(angle_of(edge, R));
  return result;
}

AngleStatistics statistics_of(std::vector<double> angles) {
  if (angles.empty()) return {};
  std::sort(angles.begin(), angles.end());
  const std::size_t n = angles.size();
  return {std::accumulate(angles.begin(), angles.end(), 0.0) / static_cast<double>(n),
          angles[n / 2], angles[std::min(n - 1, 9 * n / 10)], angles.back()};
}

ConnectedRotations::ConnectedRotations(std::int64_t nodes, std::vector<RelativeRotation> edges,
                                       std::int32_t root, linalg::ThreadPool& pool)
    : nodes_(nodes),
      edges_(std::move(edges)),
      root_(root),
      pool_(pool),
      system_(nodes, couples(), pool) {}

std::vector<PoseGraphSystem<1>::Couple> ConnectedRotations::couples() const {
  std::vector<PoseGraphSystem<1>::Couple> result;
  result.reserve(edges_.size());
  for (const RelativeRotation& edge : edges_) result.emplace_back(edge.i, edge.j);
  return result;
}

Rotations ConnectedRotations::along_tree() const {
  Rotations R(index(nodes_), Matrix3d::Identity());
  const auto weights = weighted(edges_);
  for (const TreeEdge& step : maximum_spanning_tree(nodes_, weights, root_)) {
    const RelativeRotation& edge = edges_[index(step.edge)];
    const Matrix3d R_cp = edge.i == step.parent ? edge.R_ji : Matrix3d(edge.R_ji.transpose());
    R[index(step.child)] = R_cp * R[index(step.parent)];
  }
  return R;
}

Rotations ConnectedRotations::chordal() const {
  PoseGraphSystem<3> system(nodes_, couples(), pool_);
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(3 * nodes_, 3);
  for (const RelativeRotation& edge : edges_) {
    const Matrix3d W = edge.weight * Matrix3d::Identity();
    system.add(edge.i, edge.i, W);
    system.add(edge.j, edge.j, W);
    system.add(edge.i, edge.j, -edge.weight * edge.R_ji.transpose());
    if (edge.i == root_) X.middleRows<3>(3 * edge.j) += edge.weight * edge.R_ji;
    if (edge.j == root_) X.middleRows<3>(3 * edge.i) += edge.weight * edge.R_ji.transpose();
  }
  X.middleRows<3>(3 * root_).setIdentity();
  system.hold(root_);
  if (!system.factor()) return along_tree();
  system.solve(X);
  Rotations R;
  R.reserve(index(nodes_));
  for (std::int64_t i = 0; i < nodes_; ++i) R.push_back(so3::nearest(X.middleRows<3>(3 * i)));
  return R;
}

int ConnectedRotations::refine(Rotations& R, int most_iterations, double widest) {
  constexpr double smallest_scale = 1e-7, smallest_step = 1e-5, narrowing = 0.7;
  double scale = widest;
  int iteration = 0;
  while (iteration < most_iterations) {
    ++iteration;
    const double median = std::max(smallest_scale, statistics_of(angles(R)).median);
    const bool narrow = scale <= median;
    if (step(R, std::max(scale, median)) < smallest_step && narrow) break;
    scale *= narrowing;
  }
  return iteration;
}

double ConnectedRotations::robust_sum(const Rotations& R) const {
  double sum = 0;
  for (const double angle : angles(R)) sum += std::sqrt(angle);
  return sum;
}

// R_i <- R_i Exp(w_i), where log(R_j^T R_ji R_i) becomes its sum with w_i - w_j to first order;
// returns the largest turn.
double ConnectedRotations::step(Rotations& R, double scale) {
  using Weight = PoseGraphSystem<1>::Block;
  Eigen::MatrixXd w = Eigen::MatrixXd::Zero(nodes_, 3);
  system_.set_zero();
  for (const RelativeRotation& edge : edges_) {
    const Vector3d r = disagreement(edge, R);
    const double weight = std::pow(1 + r.squaredNorm() / (scale * scale), -0.75);
    system_.add(edge.i, edge.i, Weight(weight));
    system_.add(edge.j, edge.j, Weight(weight));
    system_.add(edge.i, edge.j, Weight(-weight));
    w.row(edge.i) -= weight * r;
    w.row(edge.j) += weight * r;
  }
  w.row(root_).setZero();
  system_.hold(root_);
  if (!system_.factor()) return 0;
  system_.solve(w);
  double largest = 0;
  for (std::int64_t i = 0; i < nodes_; ++i) {
    const Vector3d turn = w.row(i);
    R[index(i)] = so3::nearest(R[index(i)] * so3::exp(turn));
    largest = std::max(largest, turn.norm());
  }
  return largest;
}

}  // namespace raybundle::init
