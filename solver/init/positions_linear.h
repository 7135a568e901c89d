#pragma once

#include <raybundle/solver/init/features.h>

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace raybundle::init {

struct LinearPositionOptions {
  int rounds = 3;         ///< of reweighting; the first has equal weights
  double scale = 4;       ///< pixels, of Cauchy's loss that the weights of later rounds follow
  int admm_steps = 1000;  ///< of a round, at most, where points come out behind cameras
};

struct LinearPositions {
  std::vector<Eigen::Vector3d> P;   ///< of an image; 0 where it is not known
  std::vector<std::uint8_t> known;  ///< 1: in the largest set that features tie together
  std::int64_t rows = 0;            ///< sightings of features
  std::int64_t rows_behind = 0;     ///< of these, behind their image at first
  int admm_steps = 0;
};

/// Positions of images of known rotation from rays to features [Liu18, Eq. 14]:
///   minimise sum w |v_k x N_k|^2   such that v_k . N_k >= 0, sum v_k . N_k = rows, P_root = 0
/// with v the observed ray in the world and N linear in positions; where nothing ties the root to
/// the largest set of images, another one stands at 0. A convex quadratic programme: without the
/// inequalities it takes one factorisation, and where points come out behind their images the
/// method of multipliers adds them [Boyd11, 5.2]. Weights are 1, and in later rounds those of
/// Cauchy's loss of the angles between v and N; rows of little weight then have no inequality.
LinearPositions linear_positions(const Sightings& sightings, std::span<const Feature> features,
                                 const std::vector<Eigen::Matrix3d>& R_cw,
                                 std::span<const std::uint8_t> known, std::int32_t root,
                                 const LinearPositionOptions& options, linalg::ThreadPool& pool);

}  // namespace raybundle::init
