#include <raybundle/models/camera_modes.h>

#include <raybundle/models/problem.h>
#include <raybundle/models/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <cstdint>

namespace raybundle {
namespace {

using so3::Matrix3;
using so3::Vector3;
using Modes = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int similarity_freedoms = 7;

Vector3 centre_of(const double* camera) {
  return -so3::exp(Eigen::Map<const Vector3>(camera)).transpose() *
         Eigen::Map<const Vector3>(camera + 3);
}

// The world moves by X' = X + omega x (X - c) + tau + sigma (X - c). A camera that sees the same
// has R' = R Exp(-omega) and its centre P moved likewise, and t' = -R' P'.
void pose_modes(PoseUpdate update, const double* camera, const Vector3& c, Modes& modes) {
  const Vector3 phi = Eigen::Map<const Vector3>(camera);
  const Vector3 t = Eigen::Map<const Vector3>(camera + 3);
  const Matrix3 R = so3::exp(phi);
  const Vector3 from_centre = centre_of(camera) - c;
  for (int k = 0; k < similarity_freedoms; ++k) {
    const Vector3 omega = k < 3 ? Vector3(Vector3::Unit(k)) : Vector3(Vector3::Zero());
    Vector3 delta_P = omega.cross(from_centre);
    if (k >= 3 && k < 6) delta_P = Vector3::Unit(k - 3);
    if (k == 6) delta_P = from_centre;
    // t = -R P, and R' = R (I - hat(omega))
    const Vector3 delta_t = -R * delta_P - R * omega.cross(R.transpose() * t);
    switch (update) {
      case PoseUpdate::global:
        modes.block<3, 1>(0, k) = -so3::inverse_right_jacobian(phi) * omega;
        modes.block<3, 1>(3, k) = delta_t;
        break;
      case PoseUpdate::local:
        modes.block<3, 1>(0, k) = -omega;
        modes.block<3, 1>(3, k) = R.transpose() * delta_t;
        break;
      case PoseUpdate::se3:  // Exp(delta_phi) R = R Exp(-omega), and t turns with it
        modes.block<3, 1>(0, k) = -R * omega;
        modes.block<3, 1>(3, k) = delta_t + (R * omega).cross(t);
        break;
    }
  }
}

}  // namespace

void camera_modes(PoseUpdate update, const std::vector<double>& cameras, int unknowns,
                  double* modes) {
  const auto count = static_cast<std::int64_t>(cameras.size()) / Problem::camera_size;
  const int width = unknowns + 1;
  Vector3 mean = Vector3::Zero();
  for (std::int64_t i = 0; i < count; ++i) {
    mean += centre_of(cameras.data() + i * Problem::camera_size) / static_cast<double>(count);
  }
  Modes of_camera(unknowns, width);
  for (std::int64_t i = 0; i < count; ++i) {
    const double* camera = cameras.data() + i * Problem::camera_size;
    of_camera.setZero();
    pose_modes(update, camera, mean, of_camera);
    for (int k = 6; k < unknowns; ++k) of_camera(k, k + 1) = k == 6 ? camera[k] : 1;
    std::copy_n(of_camera.data(), of_camera.size(), modes + i * of_camera.size());
  }
}

}  // namespace raybundle
