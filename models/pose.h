#pragma once

namespace raybundle {

/// How a pose takes a step (delta_phi, delta_t), both 3-vectors:
///   global  phi + delta_phi,             t + delta_t             [Qu18, Eq. 3.19, 3.20]
///   local   R Exp(delta_phi),            t + R delta_t           [Qu18, Eq. 4.1, 4.2]
///   se3     Exp(delta_phi) R,            Exp(delta_phi) t + J_l(delta_phi) delta_t
/// The last composes the exponential of the twist with (R_cw, t_cw) on the camera's side: in the
/// camera-to-world pose of [Liu18, 2.2] it stands on the right, which is called left-invariant.
enum class PoseUpdate { global, local, se3 };

/// Writes the pose that follows `pose` (rotation vector, translation) after `step` to `next`; six
/// numbers each, `next` may be `pose`.
void retract_pose(PoseUpdate update, const double* pose, const double* step, double* next);

}  // namespace raybundle
