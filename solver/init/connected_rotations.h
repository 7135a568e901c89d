#pragma once

#include <raybundle/linalg/parallel.h>
#include <raybundle/solver/init/pose_graph_system.h>
#include <raybundle/solver/init/rotation_averaging.h>

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace raybundle::init {

using Rotations = std::vector<Eigen::Matrix3d>;

/// |log(R_j^T R_ji R_i)| of an edge: how far it is from agreement, radians.
double angle_of(const RelativeRotation& edge, const Rotations& R);
std::vector<double> angles_of(std::span<const RelativeRotation> edges, const Rotations& R);
AngleStatistics statistics_of(std::vector<double> angles);

/// Rotations of the nodes 0 .. nodes - 1 of a connected graph, the root's the identity.
class ConnectedRotations {
 public:
  ConnectedRotations(std::int64_t nodes, std::vector<RelativeRotation> edges, std::int32_t root,
                     linalg::ThreadPool& pool);

  /// Along a spanning tree of greatest weight.
  Rotations along_tree() const;
  /// The least weighted sum of |R_j - R_ji R_i|^2 over matrices, then the nearest rotations
  /// [Carlone15, III-B].
  Rotations chordal() const;
  /// Returns the iterations of reweighting [Chatterjee13]. Disagreements count as squares below a
  /// scale, which begins so wide that all do, and narrows to their median: from a start that agrees
  /// with a few wrong edges at the price of many right ones, a narrow one would never get away.
  int refine(Rotations& R, int most_iterations, double widest);
  /// What is to be small: large disagreements count little.
  double robust_sum(const Rotations& R) const;
  std::vector<double> angles(const Rotations& R) const { return angles_of(edges_, R); }

 private:
  std::vector<PoseGraphSystem<1>::Couple> couples() const;
  double step(Rotations& R, double scale);

  std::int64_t nodes_;
  std::vector<RelativeRotation> edges_;
  std::int32_t root_;
  linalg::ThreadPool& pool_;
  PoseGraphSystem<1> system_;  // of all three components of a turn alike
};

}  // namespace raybundle::init
