#pragma once

#include <raybundle/solver/init/rotation_averaging.h>
#include <raybundle/solver/init/sightings.h>
#include <raybundle/solver/init/view_graph.h>

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace raybundle::init {

/// A point as its parallax tells it, without any scale [Liu18, 3.1, Remark 5], and the linear form
/// of the ray from image i to it [Liu18, Eq. 12]:
///   N_i = G (P_a - P_m) + sin_theta (P_m - P_i),   G = sin(alpha - theta) Exp((pi - alpha) n_z)
/// where the direction from m to a is that of the pair's epipolar geometry.
struct Feature {
  std::int32_t point = 0;
  std::int32_t main = 0, associate = 0;  ///< images: its anchors
  double sin_theta = 0;                  ///< of the parallax angle
  Eigen::Matrix3d G;

  double scale() const {
    return G.col(0).norm();
  }  ///< |N| of the main anchor's ray, over |P_a - P_m|
  /// The coefficients of the positions of main, associate and observing image in N.
  Eigen::Matrix3d of_main() const { return -G + sin_theta * Eigen::Matrix3d::Identity(); }
  const Eigen::Matrix3d& of_associate() const { return G; }
  double of_observer() const { return -sin_theta; }
};

struct Features {
  std::vector<Feature> all;               ///< ascending by point
  std::vector<std::uint8_t> disagreeing;  ///< of a sighting: 1, of those that it could agree with
                                          ///< it does with half the share of others or less
};

/// Features of all points that two images of known rotation saw which are an edge of the graph with
/// a translation, in accordance with it as the pair alone tells it: to `threshold` pixels, and in
/// front of both. The anchors
/// are that pair with the best parallax, the largest angle below a right one [Zhao15], whose
/// sightings do not disagree with the rest of the track. Of long tracks 32 observers, evenly
/// spaced, are compared.
Features features(const Sightings& sightings, const ViewGraph& graph,
                  const std::vector<Eigen::Matrix3d>& R_cw, std::span<const std::uint8_t> known,
                  double threshold, linalg::ThreadPool& pool);

/// The ray of a sighting in the world.
Eigen::Vector3d world_ray(const Sightings& sightings, const std::vector<Eigen::Matrix3d>& R_cw,
                          std::int64_t sighting);

}  // namespace raybundle::init
