#include <raybundle/models/pose.h>

#include <raybundle/models/rotation.h>

namespace raybundle {

void retract_pose(PoseUpdate update, const double* pose, const double* step, double* next) {
  using so3::Vector3;
  const Vector3 phi = Eigen::Map<const Vector3>(pose);
  const Vector3 t = Eigen::Map<const Vector3>(pose + 3);
  const Vector3 delta_phi = Eigen::Map<const Vector3>(step);
  const Vector3 delta_t = Eigen::Map<const Vector3>(step + 3);
  Eigen::Map<Vector3> next_phi(next);
  Eigen::Map<Vector3> next_t(next + 3);
  switch (update) {
    case PoseUpdate::global:
      next_phi = phi + delta_phi;
      next_t = t + delta_t;
      return;
    case PoseUpdate::local:
      next_phi = so3::compose(phi, delta_phi);
      next_t = t + so3::exp(phi) * delta_t;
      return;
    case PoseUpdate::se3:
      // J_l(phi) = J_r(-phi) [Sola17].
      next_phi = so3::compose(delta_phi, phi);
      next_t = so3::exp(delta_phi) * t + so3::right_jacobian(-delta_phi) * delta_t;
      return;
  }
}

}  // namespace raybundle
