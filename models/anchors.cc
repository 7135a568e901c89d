#include <raybundle/models/anchors.h>

#include <raybundle/models/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>

namespace raybundle {
namespace {

using Eigen::Vector3d;
using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

struct Observer {
  std::int64_t row;
  std::int32_t camera;
  Vector3d direction;  // in the world
  Vector3d centre;
};

Observer observer(const SeenRays& seen, std::int64_t row) {
  const std::int32_t camera = seen.camera[row];
  const Eigen::Map<const RowMajor> R_cw(seen.R_cw + 9 * std::int64_t{camera});
  return {row, camera, R_cw.transpose() * Eigen::Map<const Vector3d>(seen.ray + 3 * row),
          Eigen::Map<const Vector3d>(seen.centre + 3 * std::int64_t{camera})};
}

bool apart(const Observer& a, const Observer& b) {
  const double size = a.centre.cwiseAbs().maxCoeff() + b.centre.cwiseAbs().maxCoeff();
  return a.camera != b.camera && (a.centre - b.centre).norm() > 1e-12 * size;
}

}  // namespace

double anchor_quality(const Vector3d& a, const Vector3d& b) {
  const double sine = a.cross(b).norm();
  return a.dot(b) >= 0 ? sine : sine - 2;
}

CameraPoses::CameraPoses(const std::vector<double>& cameras) {
  const std::size_t count = cameras.size() / Problem::camera_size;
  R_cw_.resize(9 * count);
  P_.resize(3 * count);
  for (std::size_t c = 0; c < count; ++c) {
    const double* camera = cameras.data() + c * Problem::camera_size;
    const so3::Matrix3 R = so3::exp(Vector3d(Eigen::Map<const Vector3d>(camera)));
    Eigen::Map<RowMajor>(R_cw_.data() + 9 * c) = R;
    Eigen::Map<Vector3d>(P_.data() + 3 * c) =
        -(R.transpose() * Eigen::Map<const Vector3d>(camera + 3));
  }
}

AnchorPoses CameraPoses::of(const Anchors& anchors) const {
  return {R_cw(anchors.main), P(anchors.main),
          anchors.associate < 0 ? nullptr : P(anchors.associate)};
}

SeenRays CameraPoses::seen(std::span<const std::int32_t> row_camera,
                           std::span<const double> rays) const {
  return {row_camera.data(), rays.data(), R_cw_.data(), P_.data()};
}

AnchorRows choose_anchors(const SeenRays& seen, Track track, bool first_is_main) {
  AnchorRows best;
  const std::int64_t count = std::min(track.last - track.first, most_compared_anchors);
  if (count == 0) return best;
  std::array<Observer, most_compared_anchors> observers;
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t length = track.last - track.first;
    const std::int64_t row = track.first + (count > 1 ? i * (length - 1) / (count - 1) : 0);
    observers[static_cast<std::size_t>(i)] = observer(seen, row);
  }
  best.anchors.main = observers[0].camera;
  best.main_row = observers[0].row;
  double most = -3;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    for (std::size_t j = i + 1; j < static_cast<std::size_t>(count); ++j) {
      const Observer &a = observers[i], &b = observers[j];
      if (!apart(a, b)) continue;
      const double of_pair = anchor_quality(a.direction, b.direction);
      if (of_pair <= most) continue;
      most = of_pair;
      best = {{a.camera, b.camera}, a.row, b.row};
    }
    if (first_is_main) break;
  }
  return best;
}

}  // namespace raybundle
