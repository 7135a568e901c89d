// The quadratic programme of positions against what a minimum under inequalities has to be, and the
// images that rays tell.

#include <raybundle/solver/init/position_programme.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/QR>

#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/sphere.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/tests/solver/init/forgotten.h>
#include <raybundle/tests/solver/init/true_graph.h>

namespace raybundle::init {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Features and rays by true rotations; observers agree within so many pixels.
struct Seen {
  std::vector<Feature> features;
  std::vector<FeatureRay> rays;

  Seen(const Problem& truth, const Problem& problem, double threshold) {
    linalg::ThreadPool pool(1);
    const Sightings sightings(problem, pool);
    const auto R_cw = camera_rotations(truth);
    const std::vector<std::uint8_t> all(R_cw.size(), 1);
    const auto graph = test::true_graph(truth, sightings, pool);
    features = init::features(sightings, graph, R_cw, all, threshold, pool).all;
    rays = feature_rays(sightings, features, R_cw, all);
  }

  // v . N of each ray as a row, and H = sum N^T (I - v v^T) N.
  MatrixXd depths(std::int64_t images) const {
    MatrixXd A = MatrixXd::Zero(static_cast<Eigen::Index>(rays.size()), 3 * images);
    for (Eigen::Index k = 0; k < A.rows(); ++k) {
      A.row(k) = rays[static_cast<std::size_t>(k)].v.transpose() * N(k, images);
    }
    return A;
  }
  MatrixXd squares(std::int64_t images) const {
    MatrixXd H = MatrixXd::Zero(3 * images, 3 * images);
    for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(rays.size()); ++k) {
      const Eigen::Vector3d& v = rays[static_cast<std::size_t>(k)].v;
      const MatrixXd N_k = N(k, images);
      H += N_k.transpose() * (Eigen::Matrix3d::Identity() - v * v.transpose()) * N_k;
    }
    return H;
  }

 private:
  MatrixXd N(Eigen::Index k, std::int64_t images) const {
    const FeatureRay& ray = rays[static_cast<std::size_t>(k)];
    MatrixXd result = MatrixXd::Zero(3, 3 * images);
    for (const auto& term : ray.terms(features[static_cast<std::size_t>(ray.feature)])) {
      result.middleCols<3>(3 * term.image) += term.coefficient;
    }
    return result;
  }
};

constexpr std::int64_t images = 8;

// At the minimum H x = nu c + A^T lambda, lambda >= 0 and not 0 only where A x = 0.
TEST(PositionProgramme, EndsWhereNothingThatIsAllowedIsBetter) {
  linalg::ThreadPool pool(2);
  const scenes::Scene scene = scenes::street_scene({.cameras = images, .points = 80});
  const Problem noisy = add_noise(scene, {.pixel_noise = 8, .outlier_share = 0.1}).problem;
  const Seen seen(scene.truth, noisy, 200);
  PositionProgramme programme(images, 0, seen.features, seen.rays, pool);
  VectorXd x;
  ASSERT_TRUE(programme.solve(x));
  const MatrixXd A = seen.depths(images), H = seen.squares(images);
  const auto count = static_cast<double>(A.rows());
  EXPECT_NEAR((A * x).sum(), count, 1e-6 * count);
  EXPECT_LT((A * x - programme.depths(x)).norm(), 1e-9 * x.norm());
  ASSERT_LT((A * x).minCoeff(), -0.01) << "else there is nothing to constrain";
  const double before = x.dot(H * x);

  const auto steps = programme.constrain(x, 20000);
  EXPECT_TRUE(steps.converged);
  EXPECT_GT(steps.count, 1);
  EXPECT_GT((A * x).minCoeff(), -2e-3);
  EXPECT_NEAR((A * x).sum(), count, 1e-6 * count);
  EXPECT_LT(x.head<3>().norm(), 1e-12);
  EXPECT_GT(x.dot(H * x), before);

  std::vector<Eigen::Index> active;
  for (Eigen::Index k = 0; k < A.rows(); ++k) {
    if (A.row(k).dot(x) < 2e-3) active.push_back(k);
  }
  MatrixXd normals(3 * images - 3, static_cast<Eigen::Index>(active.size()) + 1);
  normals.col(0) = A.colwise().sum().tail(3 * images - 3).transpose();
  for (std::size_t i = 0; i < active.size(); ++i) {
    normals.col(static_cast<Eigen::Index>(i) + 1) =
        A.row(active[i]).tail(3 * images - 3).transpose();
  }
  const VectorXd gradient = (H * x).tail(3 * images - 3);
  const VectorXd multipliers = normals.colPivHouseholderQr().solve(gradient);
  EXPECT_LT((normals * multipliers - gradient).norm(), 0.02 * gradient.norm());
  EXPECT_GT(multipliers.tail(multipliers.size() - 1).minCoeff(), -0.02 * gradient.norm());
  EXPECT_FALSE(programme.constrain(x, 0).count > 0);
}

TEST(PositionProgramme, RaysThatFitBadlyLoseTheirWeight) {
  linalg::ThreadPool pool(1);
  const scenes::Scene scene = scenes::street_scene({.cameras = images, .points = 200});
  const Problem noisy = add_noise(scene, {.pixel_noise = 0.5, .outlier_share = 0.05}).problem;
  const Seen seen(scene.truth, noisy, 200);
  PositionProgramme programme(images, 0, seen.features, seen.rays, pool);
  VectorXd x;
  ASSERT_TRUE(programme.solve(x));
  for (int round = 0; round < 5; ++round) {
    programme.reweight(x, 4);
    ASSERT_TRUE(programme.solve(x));
  }
  const VectorXd depths = programme.depths(x);
  const auto dropped = (depths.array() == 0).count();
  EXPECT_GT(dropped, depths.size() / 100);
  EXPECT_LT(dropped, depths.size() / 5);
}

std::vector<std::uint8_t> determined(const Problem& problem) {
  const Seen seen(problem, problem, 2);
  return determined_images(problem.camera_count(), seen.features, seen.rays);
}

TEST(DeterminedImages, AreAllOfAScene) {
  const auto street = scenes::street_scene({.cameras = 20, .points = 600}).truth;
  EXPECT_EQ(determined(street), std::vector<std::uint8_t>(20, 1));
  const auto sphere = scenes::sphere_scene({.cameras = 12, .points = 400, .region = 0.5}).truth;
  EXPECT_EQ(determined(sphere), std::vector<std::uint8_t>(12, 1));
}

// What two images alone see tells a direction; how far along it takes a third that saw it too.
TEST(DeterminedImages, AreNotThoseThatCanSlide) {
  const auto sphere = scenes::sphere_scene({.cameras = 12, .points = 400, .region = 0.5}).truth;
  const auto of_last = [&](bool with_one_alone) {
    return determined(test::thinned(sphere, [&](std::int32_t camera, std::int32_t point) {
      if (point >= 60) return camera < 11;
      return camera == 11 || (with_one_alone ? camera == 0 : camera < 3);
    }));
  };
  std::vector<std::uint8_t> expected(12, 1);
  EXPECT_EQ(of_last(false), expected);
  expected[11] = 0;
  EXPECT_EQ(of_last(true), expected);
}

TEST(DeterminedImages, AreTheLargerOfTwoGroups) {
  const auto sphere = scenes::sphere_scene({.cameras = 12, .points = 400, .region = 0.5}).truth;
  const auto found = determined(test::thinned(sphere, [](std::int32_t camera, std::int32_t point) {
    return (point < 150) == (camera < 5);
  }));
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(found[i] != 0, i >= 5) << i;
}

}  // namespace
}  // namespace raybundle::init
