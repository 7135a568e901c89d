#pragma once

#include <raybundle/linalg/parallel.h>
#include <raybundle/solver/init/graph.h>

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace raybundle::init {

/// R_j = R_ji R_i, as measured.
struct RelativeRotation {
  std::int32_t i = 0, j = 0;
  Eigen::Matrix3d R_ji = Eigen::Matrix3d::Identity();
  double weight = 1;  ///< inliers, say: which edges the starts prefer; no matter then
  std::optional<Eigen::Matrix3d> other = {};  ///< another R_ji that may be the right one as well
};

struct RotationOptions {
  double prune = 6;  ///< degrees: edges that disagree by more are left out in the end
  int most_iterations = 100;
};

/// How far measurements are from agreement: radians.
struct AngleStatistics {
  double mean = 0, median = 0, upper_decile = 0, largest = 0;
};

struct AveragedRotations {
  std::vector<Eigen::Matrix3d> R_cw;  ///< of an image; the identity where it is not known
  std::vector<std::uint8_t> known;    ///< 1: it is in the largest component of the edges left
  std::int32_t root = 0;              ///< whose rotation is the identity, unless given
  std::vector<double> angle;          ///< of an edge: |log(R_j^T R_ji R_i)|; NaN where not known
  std::vector<std::uint8_t> pruned;   ///< of an edge: 1, it disagrees
  std::optional<AngleStatistics> tree, chordal;  ///< of all edges at the two starts
  AngleStatistics before, after;                 ///< pruning
  int iterations = 0;                            ///< of the robust refinement
};

/// Rotations of all images of the largest component, from measured ones of pairs: a spanning tree
/// of greatest weight and the chordal start [Carlone15, III] are both refined on SO(3) by
/// reweighting with |angle|^(-3/2) [Chatterjee13], and the better one is kept; edges that disagree
/// are then left out, and the rest is refined again. Where edges have another rotation, all is done
/// again while the other one is nearer. Throws std::invalid_argument where an edge has no such
/// images.
AveragedRotations average_rotations(std::int64_t images, std::span<const RelativeRotation> edges,
                                    const RotationOptions& options, linalg::ThreadPool& pool);

/// Rotations that are known beforehand in the place of averaged ones: they stay, and edges are
/// judged by them alone. Throws std::invalid_argument as average_rotations() does.
AveragedRotations given_rotations(const std::vector<Eigen::Matrix3d>& R_cw,
                                  std::span<const RelativeRotation> edges,
                                  const RotationOptions& options);

}  // namespace raybundle::init
