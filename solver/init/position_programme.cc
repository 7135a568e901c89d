#include <raybundle/solver/init/position_programme.h>

#include <raybundle/linalg/block_layout.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using linalg::index;

}  // namespace

PositionProgramme::PositionProgramme(std::int64_t images, std::int32_t root,
                                     std::vector<Feature> features, std::vector<FeatureRay> rays,
                                     linalg::ThreadPool& pool)
    : features_(std::move(features)),
      rays_(std::move(rays)),
      root_(root),
      order_(3 * images),
      pool_(pool),
      weight_(VectorXd::Ones(count())),
      constrained_(rays_.size(), 1),
      system_(images, couples(), pool) {}

bool PositionProgramme::solve(VectorXd& x) {
  const VectorXd c = sum_of_depths();
  fill();
  system_.keep();
  system_.hold(root_);
  if (!system_.factor()) return false;
  Eigen::MatrixXd direction = c;
  system_.solve(direction);
  const VectorXd found = direction * (static_cast<double>(count()) / c.dot(direction.col(0)));
  if (!found.allFinite()) return false;
  x = found;
  return true;
}

PositionProgramme::Steps PositionProgramme::constrain(VectorXd& x, int most_steps) {
  const VectorXd c = sum_of_depths();
  std::vector<Constraint> working;
  Steps steps;
  while (steps.converged && add_broken(x, working)) {
    const Steps more = solve_with(working, c, x, most_steps - steps.count);
    steps.count += more.count;
    steps.converged = more.converged;
  }
  return steps;
}

void PositionProgramme::reweight(const VectorXd& x, double scale) {
  parallel([&](std::int64_t k) {
    const FeatureRay& ray = rays_[index(k)];
    const Vector3d N = towards_feature(ray, x);
    const double length = std::max(N.norm(), 1e-3);
    const double error = ray.v.cross(N).norm() / length * ray.pixels;
    const double robust = 1 / (1 + error * error / (scale * scale));
    weight_[k] = robust;
    constrained_[index(k)] = robust > 0.1 ? 1 : 0;
  });
  weight_ /= weight_.mean();
}

VectorXd PositionProgramme::depths(const VectorXd& x) const {
  VectorXd result(count());
  parallel([&](std::int64_t k) {
    const FeatureRay& ray = rays_[index(k)];
    result[k] = constrained_[index(k)] != 0 ? ray.v.dot(towards_feature(ray, x)) : 0;
  });
  return result;
}

// False where there is none to add.
bool PositionProgramme::add_broken(const VectorXd& x, std::vector<Constraint>& working) const {
  constexpr double tolerance = 1e-3;  // of a mean depth of 1
  const VectorXd depth = depths(x);
  std::vector<std::int64_t> known;
  known.reserve(working.size());
  for (const Constraint& each : working) known.push_back(each.ray);
  for (std::int64_t k = 0; k < count(); ++k) {
    if (!(depth[k] < -tolerance)) continue;
    if (!std::binary_search(known.begin(), known.end(), k)) working.push_back({k});
  }
  if (working.size() == known.size()) return false;
  std::sort(working.begin(), working.end(),
            [](const Constraint& a, const Constraint& b) { return a.ray < b.ray; });
  return true;
}

// Alternates between x with a sum of depths as asked for, and z >= 0. What a squared distance
// between depth and z costs, rho, follows from which of the two lags behind [Boyd11, 3.4.1].
PositionProgramme::Steps PositionProgramme::solve_with(std::vector<Constraint>& working,
                                                       const VectorXd& c, VectorXd& x,
                                                       int most_steps) {
  constexpr double tolerance = 5e-4, lag = 4;
  constexpr int steps_of_rho = 25;
  double rho = 1e-2;
  Eigen::MatrixXd towards_c;
  Gap gap;
  for (int step = 0; step < most_steps; ++step) {
    if (step % steps_of_rho == 0) {
      if (gap.primal > lag * gap.dual) rho *= lag;
      if (gap.dual > lag * gap.primal) rho /= lag;
      if (!factor_with(working, rho)) return {step, false};
      towards_c = c;
      system_.solve(towards_c);
    }
    VectorXd sums = VectorXd::Zero(order_);
    for (const Constraint& each : working) {
      add_transposed(each.ray, rho * each.z - each.multiplier, sums);
    }
    sums.segment<3>(3 * root_).setZero();
    Eigen::MatrixXd next = sums;
    system_.solve(next);
    const double missing = static_cast<double>(count()) - c.dot(next.col(0));
    x = next + towards_c * (missing / c.dot(towards_c.col(0)));
    gap = move_multipliers(working, rho, x);
    if (gap.primal < tolerance && gap.dual < tolerance) return {step + 1, true};
  }
  return {most_steps, false};
}

bool PositionProgramme::factor_with(const std::vector<Constraint>& working, double rho) {
  system_.restore();
  for (const Constraint& each : working) {
    const FeatureRay& ray = rays_[index(each.ray)];
    add_ray(ray, rho * ray.v * ray.v.transpose());
  }
  system_.hold(root_);
  return system_.factor();
}

PositionProgramme::Gap PositionProgramme::move_multipliers(std::vector<Constraint>& working,
                                                           double rho, const VectorXd& x) const {
  Gap gap;
  for (Constraint& each : working) {
    const FeatureRay& ray = rays_[index(each.ray)];
    const double depth = ray.v.dot(towards_feature(ray, x));
    const double z = std::max(0.0, depth + each.multiplier / rho);
    gap.dual = std::max(gap.dual, std::abs(z - std::exchange(each.z, z)));
    each.multiplier += rho * (depth - z);
    gap.primal = std::max(gap.primal, std::abs(depth - z));
  }
  return gap;
}

std::vector<PoseGraphSystem<3>::Couple> PositionProgramme::couples() const {
  std::vector<PoseGraphSystem<3>::Couple> result;
  result.reserve(3 * rays_.size());
  for (const FeatureRay& ray : rays_) {
    const Feature& feature = features_[index(ray.feature)];
    result.emplace_back(feature.main, feature.associate);
    result.emplace_back(feature.main, ray.image);
    result.emplace_back(feature.associate, ray.image);
  }
  return result;
}

template <class Body>
void PositionProgramme::parallel(Body&& body) const {
  linalg::parallel_for(pool_, count(), 1024, [&](std::int64_t first, std::int64_t last) {
    for (; first < last; ++first) body(first);
  });
}

Vector3d PositionProgramme::towards_feature(const FeatureRay& ray, const VectorXd& x) const {
  const Feature& feature = features_[index(ray.feature)];
  const Vector3d P_m = x.segment<3>(3 * feature.main), P_a = x.segment<3>(3 * feature.associate);
  const Vector3d P_i = x.segment<3>(3 * ray.image);
  return feature.G * (P_a - P_m) + feature.sin_theta * (P_m - P_i);
}

// c: c^T x is the sum of v . N of all rays with an inequality. Pieces of rays have sums of their
// own, added in order.
VectorXd PositionProgramme::sum_of_depths() const {
  const linalg::Chunks pieces = linalg::chunks(count(), 4096, 16);
  std::vector<VectorXd> parts(index(pieces.pieces));
  pool_.run(pieces.pieces, [&](std::int64_t piece) {
    VectorXd& part = parts[index(piece)];
    part = VectorXd::Zero(order_);
    for (std::int64_t k = pieces.begin(piece); k < pieces.end(piece); ++k) {
      if (constrained_[index(k)] != 0) add_transposed(k, 1, part);
    }
  });
  VectorXd c = VectorXd::Zero(order_);
  for (const VectorXd& part : parts) c += part;
  c.segment<3>(3 * root_).setZero();
  return c;
}

// Adds factor N^T v of a ray.
void PositionProgramme::add_transposed(std::int64_t k, double factor, VectorXd& to) const {
  const FeatureRay& ray = rays_[index(k)];
  const Feature& feature = features_[index(ray.feature)];
  const Vector3d along = factor * ray.v, moved = feature.G.transpose() * along;
  to.segment<3>(3 * feature.associate) += moved;
  to.segment<3>(3 * feature.main) += feature.sin_theta * along - moved;
  to.segment<3>(3 * ray.image) -= feature.sin_theta * along;
}

// H and a pinch of the identity.
void PositionProgramme::fill() {
  system_.set_zero();
  for (std::int64_t k = 0; k < count(); ++k) {
    const Vector3d& v = rays_[index(k)].v;
    add_ray(rays_[index(k)], weight_[k] * (Matrix3d::Identity() - v * v.transpose()));
  }
  const double pinch =
      1e-10 * weight_.mean() * static_cast<double>(count()) / static_cast<double>(order_);
  for (std::int32_t i = 0; i < order_ / 3; ++i) {
    system_.add(i, i, pinch * Matrix3d::Identity());
  }
}

// N^T W N of a ray.
void PositionProgramme::add_ray(const FeatureRay& ray, const Matrix3d& W) {
  const auto terms = ray.terms(features_[index(ray.feature)]);
  for (std::size_t p = 0; p < 3; ++p) {
    const Matrix3d left = terms[p].coefficient.transpose() * W;
    system_.add(terms[p].image, terms[p].image, left * terms[p].coefficient);
    for (std::size_t q = p + 1; q < 3; ++q) {
      const Matrix3d product = left * terms[q].coefficient;
      const bool same = terms[p].image == terms[q].image;
      system_.add(terms[p].image, terms[q].image,
                  same ? Matrix3d(product + product.transpose()) : product);
    }
  }
}

}  // namespace raybundle::init
