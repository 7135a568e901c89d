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
  std::vector<std::uint8_t> known;  ///< 1: rays tell it (feature_rays.h), and it was solved for
  std::int64_t rays = 0;
  std::int64_t rays_behind = 0;  ///< of these, behind their image at first
  int rounds = 0;                ///< carried out; fewer where the next could not be computed
  int admm_steps = 0;
  bool converged = true;  ///< the method of multipliers, in every round
};

/// Positions of images of known rotation from rays to features [Liu18, Eq. 14], which ask for
/// v . N >= 0 where the paper does for a positive depth. A convex quadratic programme
/// (position_programme.h): weights are 1, and in later rounds those of Cauchy's loss of the angles
/// between v and N. The image `root` stands at 0, or where rays do not tell it another one.
LinearPositions linear_positions(const Sightings& sightings, std::span<const Feature> features,
                                 const std::vector<Eigen::Matrix3d>& R_cw,
                                 std::span<const std::uint8_t> known, std::int32_t root,
                                 const LinearPositionOptions& options, linalg::ThreadPool& pool);

}  // namespace raybundle::init
