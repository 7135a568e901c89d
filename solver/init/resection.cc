#include <raybundle/solver/init/resection.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/models/rotation.h>
#include <raybundle/solver/init/small_descent.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <cmath>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Step = Eigen::Matrix<double, 6, 1>;

// The chord between observed and expected ray, in pixels.
double squared_error(const CameraPose& pose, const SeenPoints& seen, std::int64_t i) {
  const Vector3d X_c = pose.R_cw * seen.X.col(i) + pose.t_cw;
  const double length = X_c.norm();
  if (!(length > 0)) return 4 * seen.pixels[i] * seen.pixels[i];
  return (seen.rays.col(i) - X_c / length).squaredNorm() * seen.pixels[i] * seen.pixels[i];
}

double cost(const CameraPose& pose, const SeenPoints& seen, std::span<const std::int32_t> which,
            double scale) {
  double sum = 0;
  for (const std::int32_t i : which) {
    sum += std::log1p(squared_error(pose, seen, i) / (scale * scale));
  }
  return sum;
}

// R_cw <- Exp(phi) R_cw, t_cw <- t_cw + dt: dX_c = phi x R_cw X + dt.
Step newton_step(const CameraPose& pose, const SeenPoints& seen,
                 std::span<const std::int32_t> which, double scale, double damping) {
  Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
  Step g = Step::Zero();
  for (const std::int32_t i : which) {
    const Vector3d turned = pose.R_cw * seen.X.col(i), X_c = turned + pose.t_cw;
    const double length = X_c.norm();
    if (!(length > 0)) continue;
    const Vector3d ray = X_c / length;
    const Matrix3d by_X = (Matrix3d::Identity() - ray * ray.transpose()) / length;
    Eigen::Matrix<double, 3, 6> J;
    J << -by_X * so3::hat(turned), by_X;
    const double pixels = seen.pixels[i] * seen.pixels[i];
    const double weight = pixels / (1 + squared_error(pose, seen, i) / (scale * scale));
    H += weight * J.transpose() * J;
    g += weight * J.transpose() * (ray - seen.rays.col(i));
  }
  H.diagonal() *= 1 + damping;
  return H.ldlt().solve(-g);
}

CameraPose refined(const CameraPose& start, const SeenPoints& seen,
                   std::span<const std::int32_t> which, double scale) {
  const auto cost_of = [&](const CameraPose& pose) { return cost(pose, seen, which, scale); };
  return small_descent(start, cost_of, [&](const CameraPose& pose, double damping) {
    const Step step = newton_step(pose, seen, which, scale, damping);
    return CameraPose{so3::exp(step.head<3>()) * pose.R_cw, pose.t_cw + step.tail<3>()};
  });
}

class PoseEstimator {
 public:
  using Model = CameraPose;
  static constexpr std::size_t sample_size = 3;

  PoseEstimator(const SeenPoints& seen, double threshold) : seen_(seen), threshold_(threshold) {}

  std::int64_t size() const { return seen_.size(); }

  template <class Visit>
  void for_models(const std::array<std::int64_t, sample_size>& sample, Visit&& visit) const {
    Matrix3d X, rays;
    for (int k = 0; k < 3; ++k) {
      X.col(k) = seen_.X.col(sample[static_cast<std::size_t>(k)]);
      rays.col(k) = seen_.rays.col(sample[static_cast<std::size_t>(k)]);
    }
    for (const CameraPose& pose : poses_of_three(X, rays)) visit(pose);
  }

  Fit fit(const CameraPose& pose) const {
    return fit_of(size(), threshold_,
                  [&](std::int64_t i) { return squared_error(pose, seen_, i); });
  }

  std::optional<CameraPose> improved(const CameraPose& pose) const {
    return refined(pose, seen_, inliers(pose), 0.5 * threshold_);
  }

  std::vector<std::int32_t> inliers(const CameraPose& pose) const {
    return inliers_of(size(), threshold_,
                      [&](std::int64_t i) { return squared_error(pose, seen_, i); });
  }

 private:
  const SeenPoints& seen_;
  double threshold_;
};

}  // namespace

SeenPoints seen_points(const Sightings& sightings, std::int32_t image,
                       std::span<const std::uint8_t> points, const Problem& problem) {
  std::vector<std::int32_t> of_marked;
  for (const std::int32_t s : sightings.of_image(image)) {
    if (points[linalg::index(sightings.point(s))] != 0) of_marked.push_back(s);
  }
  const auto count = static_cast<Eigen::Index>(of_marked.size());
  SeenPoints seen = {Eigen::Matrix3Xd(3, count), Eigen::Matrix3Xd(3, count),
                     Eigen::VectorXd(count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::int32_t s = of_marked[linalg::index(k)];
    const auto point = std::ptrdiff_t{Problem::point_size} * sightings.point(s);
    seen.X.col(k) = Eigen::Map<const Vector3d>(problem.points.data() + point);
    seen.rays.col(k) = sightings.ray(s);
    seen.pixels[k] = sightings.pixels(s);
  }
  return seen;
}

std::optional<Resection> resection(const SeenPoints& seen, const ResectionOptions& options,
                                   Random& random) {
  const PoseEstimator estimator(seen, options.threshold);
  const auto consensus = ransac(estimator, options.ransac, random);
  if (!consensus) return {};
  Resection result = {consensus->model, estimator.inliers(consensus->model)};
  if (static_cast<std::int64_t>(result.inliers.size()) < options.min_inliers) return {};
  return result;
}

}  // namespace raybundle::init
