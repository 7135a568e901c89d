// The pose of one image from points, and points from several images.

#include <raybundle/solver/init/resection.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/solver/init/triangulation.h>
#include <raybundle/tests/solver/init/two_views.h>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Image {
  CameraPose pose;
  SeenPoints seen;
  std::vector<bool> wrong;
};

Image image_of(std::uint64_t seed, std::int64_t points, double noise, double wrong_share) {
  constexpr double pixels = 1000;
  Random random(seed, 3);
  Image image;
  image.pose = {test::random_rotation(random, 1), test::random_vector(random)};
  image.seen = {Eigen::Matrix3Xd(3, points), Eigen::Matrix3Xd(3, points),
                Eigen::VectorXd::Constant(points, pixels)};
  image.wrong.reserve(static_cast<std::size_t>(points));
  for (std::int64_t i = 0; i < points; ++i) {
    const Vector3d X_c(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-9, -3));
    image.seen.X.col(i) = image.pose.R_cw.transpose() * (X_c - image.pose.t_cw);
    const bool wrong = random.uniform() < wrong_share;
    const Vector3d ray = wrong ? Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), -1) : X_c;
    image.seen.rays.col(i) =
        (ray.normalized() + noise / pixels * test::random_vector(random)).normalized();
    image.wrong.push_back(wrong);
  }
  return image;
}

TEST(P3p, HasTheTruePoseAmongItsOwn) {
  int exact = 0;
  constexpr int trials = 500;
  for (std::uint64_t seed = 1; seed <= trials; ++seed) {
    const Image image = image_of(seed, 3, 0, 0);
    double best = 10;
    for (const CameraPose& pose : poses_of_three(image.seen.X, image.seen.rays)) {
      best = std::min(best, test::angle_between(pose.R_cw, image.pose.R_cw) +
                                (pose.t_cw - image.pose.t_cw).norm());
    }
    exact += best < 1e-6 ? 1 : 0;
  }
  EXPECT_GE(exact, trials * 98 / 100);
}

TEST(P3p, EveryPoseSeesThePointsAlongTheRays) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Image image = image_of(seed, 3, 0, 0);
    const auto poses = poses_of_three(image.seen.X, image.seen.rays);
    EXPECT_FALSE(poses.empty()) << seed;
    for (const CameraPose& pose : poses) {
      EXPECT_NEAR(pose.R_cw.determinant(), 1, 1e-9);
      for (int k = 0; k < 3; ++k) {
        const Vector3d X_c = pose.R_cw * image.seen.X.col(k) + pose.t_cw;
        EXPECT_LT((X_c.normalized() - image.seen.rays.col(k)).norm(), 1e-4) << seed;
      }
    }
  }
}

TEST(P3p, PointsOnALineHaveNone) {
  Matrix3d X;
  X << 0, 1, 2, 0, 1, 2, 5, 5, 5;
  EXPECT_TRUE(poses_of_three(X, X.colwise().normalized()).empty());
}

TEST(Resection, FindsThePoseAmongWrongMatches) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Image image = image_of(seed, 150, 0.5, 0.4);
    Random random(seed);
    const auto found = resection(image.seen, {}, random);
    ASSERT_TRUE(found);
    EXPECT_LT(test::angle_between(found->pose.R_cw, image.pose.R_cw), 3e-3) << seed;
    EXPECT_LT((found->pose.centre() - image.pose.centre()).norm(), 2e-2) << seed;
    for (std::int32_t i = 0; i < 150; ++i) {
      const bool in = std::binary_search(found->inliers.begin(), found->inliers.end(), i);
      EXPECT_TRUE(in || image.wrong[static_cast<std::size_t>(i)]) << seed << " " << i;
    }
  }
}

TEST(Resection, NeedsEnoughThatFits) {
  Random random(1);
  EXPECT_FALSE(resection(image_of(1, 11, 0, 0).seen, {}, random));
  EXPECT_FALSE(resection(image_of(1, 60, 0, 1).seen, {}, random));
}

std::vector<WorldRay> rays_to(const Vector3d& X, int count, std::uint64_t seed, double noise) {
  Random random(seed, 8);
  std::vector<WorldRay> rays;
  rays.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const Vector3d centre = test::random_vector(random);
    const Vector3d ray = (X - centre).normalized() + noise / 1000 * test::random_vector(random);
    rays.push_back({centre, ray.normalized(), 1000});
  }
  return rays;
}

TEST(Triangulation, IsExactWithoutNoise) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Vector3d X(1, 2, 8);
    const auto found = triangulated(rays_to(X, 4, seed, 0), {});
    ASSERT_TRUE(found);
    EXPECT_LT((found->X - X).norm(), 1e-9);
  }
}

TEST(Triangulation, LeavesOutRaysThatDisagree) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Vector3d X(1, 2, 8);
    auto rays = rays_to(X, 6, seed, 0.5);
    rays[2].direction = Vector3d(0.3, -0.2, 0.9).normalized();
    const auto found = triangulated(rays, {});
    ASSERT_TRUE(found) << seed;
    EXPECT_EQ(found->used, (std::vector<std::uint8_t>{1, 1, 0, 1, 1, 1})) << seed;
    EXPECT_LT((found->X - X).norm(), 0.05);
  }
}

// From where a wrong ray alone agrees to where all others do; what is good already stays.
TEST(Triangulation, GoesToWhereMostRaysAgree) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Vector3d X(1, 2, 8);
    auto rays = rays_to(X, 5, seed, 0.5);
    EXPECT_EQ(best_agreed(rays, X, 4), X);
    rays[0].direction = Vector3d(0.3, -0.2, 0.9).normalized();
    const Vector3d astray = rays[0].centre + 5 * rays[0].direction;
    EXPECT_LT((best_agreed(rays, astray, 4) - X).norm(), 0.1) << seed;
  }
}

TEST(Triangulation, RefusesWhatHasNoParallaxOrIsBehind) {
  EXPECT_FALSE(triangulated(rays_to(Vector3d(0, 0, 1e5), 4, 1, 0), {}));
  auto behind = rays_to(Vector3d(0, 0, 8), 4, 1, 0);
  for (WorldRay& ray : behind) ray.direction = -ray.direction;
  EXPECT_FALSE(triangulated(behind, {}));
}

}  // namespace
}  // namespace raybundle::init
