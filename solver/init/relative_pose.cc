#include <raybundle/solver/init/relative_pose.h>

#include <raybundle/models/statistics.h>
#include <raybundle/solver/init/epipolar.h>
#include <raybundle/solver/init/five_point.h>
#include <raybundle/solver/init/simple_motion.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;

class EssentialEstimator {
 public:
  using Model = Matrix3d;
  static constexpr std::size_t sample_size = 5;

  EssentialEstimator(const RayPairs& pairs, double threshold)
      : pairs_(pairs), threshold_(threshold) {}

  std::int64_t size() const { return pairs_.size(); }

  template <class Visit>
  void for_models(const std::array<std::int64_t, sample_size>& sample, Visit&& visit) const {
    FiveRays a, b;
    for (int k = 0; k < 5; ++k) {
      a.col(k) = pairs_.a.col(sample[static_cast<std::size_t>(k)]);
      b.col(k) = pairs_.b.col(sample[static_cast<std::size_t>(k)]);
    }
    const EssentialMatrices matrices = essential_matrices(a, b);
    for (const Matrix3d& E : matrices.all()) visit(E);
  }

  Fit fit(const Matrix3d& E) const {
    return fit_of(size(), threshold_,
                  [&](std::int64_t i) { return squared_epipolar_error(E, pairs_, i); });
  }

  std::optional<Matrix3d> improved(const Matrix3d& E) const {
    return essential_matrix(refined(E, inliers(E)));
  }

  RelativePose refined(const Matrix3d& E, std::span<const std::int32_t> which) const {
    return refined_pose(facing_pose(E, pairs_, which, threshold_), pairs_, which, 0.5 * threshold_);
  }

  std::vector<std::int32_t> inliers(const Matrix3d& E) const {
    return inliers_of(size(), threshold_,
                      [&](std::int64_t i) { return squared_epipolar_error(E, pairs_, i); });
  }

 private:
  const RayPairs& pairs_;
  double threshold_;
};

bool is_share(std::int64_t part, std::size_t whole, double share) {
  return static_cast<double>(part) >= share * static_cast<double>(whole);
}

// The poses that a plane allows, the better one first: by the cost for each point in front.
struct PlanePose {
  RelativePose pose;
  std::int64_t front = 0;
  Fit fit;
};

std::vector<PlanePose> plane_poses(const Matrix3d& H, const RayPairs& pairs, const TwoView& view,
                                   const EssentialEstimator& estimator, double threshold) {
  std::vector<RelativePose> starts = poses_of_plane(H);
  starts.push_back(view.pose);
  std::vector<PlanePose> result;
  for (const RelativePose& start : starts) {
    RelativePose pose = refined_pose(start, pairs, view.inliers, 0.5 * threshold);
    const RelativePose back = {pose.R, -pose.t};
    const std::int64_t front = sides(pose, pairs, view.inliers, threshold).front;
    const std::int64_t front_of_back = sides(back, pairs, view.inliers, threshold).front;
    if (front_of_back > front) pose = back;
    result.push_back({pose, std::max(front, front_of_back), estimator.fit(essential_matrix(pose))});
  }
  std::stable_sort(result.begin(), result.end(), [](const PlanePose& x, const PlanePose& y) {
    return x.fit.cost * static_cast<double>(y.front + 1) <
           y.fit.cost * static_cast<double>(x.front + 1);
  });
  return result;
}

// Another pose than the best that does about as well; the end where there is none.
std::vector<PlanePose>::const_iterator rival_of_best(const std::vector<PlanePose>& poses) {
  constexpr double as_good = 0.8, as_many = 0.95, apart = 0.05;  // radians
  const PlanePose& best = poses.front();
  return std::find_if(poses.begin() + 1, poses.end(), [&](const PlanePose& other) {
    const double turn = Eigen::AngleAxisd(best.pose.R.transpose() * other.pose.R).angle();
    const double swing = (best.pose.t - other.pose.t).norm();
    return turn + swing > apart && best.fit.cost > as_good * other.fit.cost &&
           static_cast<double>(other.front) > as_many * static_cast<double>(best.front);
  });
}

double median_parallax(const TwoView& view, const RayPairs& pairs) {
  std::vector<double> angles;
  for (const std::int32_t i : view.inliers) {
    const Eigen::Vector3d a = view.pose.R * pairs.a.col(i), b = pairs.b.col(i);
    angles.push_back(std::atan2(a.cross(b).norm(), a.dot(b)));
  }
  return upper_median(std::move(angles));
}

void recognise_degeneracy(TwoView& view, const RayPairs& pairs, const RelativePoseOptions& options,
                          const EssentialEstimator& estimator) {
  const double scale = 0.5 * options.threshold;
  const Matrix3d R = pure_rotation(pairs, view.inliers, scale);
  if (is_share(explained(R, pairs, view.inliers, options.threshold), view.inliers.size(),
               options.degenerate_share)) {
    view.kind = PairKind::rotation;
    view.pose = {R, Eigen::Vector3d::Zero()};
    return;
  }
  const Matrix3d H = homography(pairs, view.inliers, scale);
  if (!is_share(explained(H, pairs, view.inliers, options.threshold), view.inliers.size(),
                options.degenerate_share)) {
    return;
  }
  view.kind = PairKind::planar;
  const std::vector<PlanePose> poses = plane_poses(H, pairs, view, estimator, options.threshold);
  view.pose = poses.front().pose;
  const auto rival = rival_of_best(poses);
  if (rival == poses.end()) return;
  view.pose.t.setZero();
  view.R_other = rival->pose.R;
}

}  // namespace

const char* name(PairKind value) {
  switch (value) {
    case PairKind::general:
      return "general";
    case PairKind::planar:
      return "planar";
    case PairKind::rotation:
      return "rotation";
  }
  return "?";
}

std::optional<TwoView> relative_pose(const RayPairs& pairs, const RelativePoseOptions& options,
                                     Random& random) {
  const std::int64_t least = std::max<std::int64_t>(options.min_inliers, 6);
  if (pairs.size() < least) return {};
  const EssentialEstimator estimator(pairs, options.threshold);
  const auto consensus = ransac(estimator, options.ransac, random);
  if (!consensus) return {};
  TwoView view;
  view.iterations = consensus->iterations;
  view.inliers = estimator.inliers(consensus->model);
  if (static_cast<std::int64_t>(view.inliers.size()) < least) return {};
  view.pose = estimator.refined(consensus->model, view.inliers);
  view.inliers = estimator.inliers(essential_matrix(view.pose));
  if (static_cast<std::int64_t>(view.inliers.size()) < least) return {};
  recognise_degeneracy(view, pairs, options, estimator);
  view.parallax = median_parallax(view, pairs);
  return view;
}

}  // namespace raybundle::init
