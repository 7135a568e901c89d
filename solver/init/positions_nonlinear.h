#pragma once

#include <raybundle/models/problem.h>
#include <raybundle/models/robust_loss.h>
#include <raybundle/solver/solve.h>

namespace raybundle::init {

struct PositionOptions {
  Loss loss = Loss::cauchy;
  double loss_scale = 4;  ///< pixels
  int max_iterations = 30;
  double function_tolerance = 1e-3;  ///< it is a start, to be solved then
  int threads = 0;
};

/// Positions of images whose rotations stay: the rays to points that keep direction and parallax,
/// as two of their rays tell them, against the observed rays [Liu18, Eq. 13]. The ray from image i
/// is the exact one [Liu18, Eq. 6] and not its linear form about the directions of the epipolar
/// geometries [Liu18, Eq. 12], whose noise it does not keep. On return the points are where that
/// puts them. Throws as solve() does.
Summary register_positions(Problem& problem, const PositionOptions& options,
                           const Observer& observer = {});

}  // namespace raybundle::init
