// Relative poses from pairs with noise and wrong matches, and what is recognised as degenerate.

#include <raybundle/solver/init/relative_pose.h>

#include <algorithm>
#include <cstdint>

#include <gtest/gtest.h>

#include <raybundle/tests/solver/init/two_views.h>

namespace raybundle::init {
namespace {

using test::Shape;
using test::two_images;

std::optional<TwoView> pose_of(const RayPairs& pairs, std::uint64_t seed = 1) {
  Random random(seed, 5);
  return relative_pose(pairs, {}, random);
}

TEST(RelativePose, IsFoundAmongWrongMatches) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto images = two_images({.seed = seed, .points = 200, .noise = 0.5, .wrong_share = 0.3});
    const auto view = pose_of(images.pairs);
    ASSERT_TRUE(view);
    EXPECT_EQ(view->kind, PairKind::general);
    EXPECT_LT(test::angle_between(view->pose.R, images.pose.R), 0.005) << seed;
    EXPECT_LT((view->pose.t - images.pose.t).norm(), 0.02) << seed;
    std::int64_t missed = 0;
    for (std::int32_t i = 0; i < 200; ++i) {
      const bool in = std::binary_search(view->inliers.begin(), view->inliers.end(), i);
      missed += !in && !images.wrong[static_cast<std::size_t>(i)] ? 1 : 0;
    }
    EXPECT_LE(missed, 2) << seed;
    EXPECT_GT(view->parallax, 0.02);
  }
}

TEST(RelativePose, ErrorsGrowInProportionToNoise) {
  const auto mean_error = [](double noise) {
    double sum = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const auto images = two_images({.seed = seed, .points = 200, .noise = noise});
      sum += test::angle_between(pose_of(images.pairs)->pose.R, images.pose.R);
    }
    return sum / 20;
  };
  EXPECT_LT(mean_error(0), 1e-7);
  EXPECT_NEAR(mean_error(0.5) / mean_error(0.25), 2, 0.4);
}

TEST(RelativePose, DependsOnSeedAlone) {
  const auto images = two_images({.points = 100, .noise = 0.5, .wrong_share = 0.3});
  const auto one = pose_of(images.pairs), two = pose_of(images.pairs);
  EXPECT_EQ(one->pose.R, two->pose.R);
  EXPECT_EQ(one->inliers, two->inliers);
}

TEST(RelativePose, PureRotationHasNoTranslation) {
  for (const auto& [shape, baseline] : {std::pair(Shape::cloud, 0.0), {Shape::far, 1.0}}) {
    const auto images = two_images({.seed = 4,
                                    .points = 150,
                                    .shape = shape,
                                    .noise = 0.5,
                                    .wrong_share = 0.1,
                                    .baseline = baseline});
    const auto view = pose_of(images.pairs);
    ASSERT_TRUE(view);
    EXPECT_EQ(view->kind, PairKind::rotation);
    EXPECT_TRUE(view->pose.t.isZero(0));
    EXPECT_LT(test::angle_between(view->pose.R, images.pose.R), 1e-3);
  }
}

// A plane allows two poses; the true one or none is chosen.
TEST(RelativePose, PlanesAreRecognisedAndNotMistaken) {
  int told = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto images =
        two_images({.seed = seed, .points = 150, .shape = Shape::plane, .noise = 0.5});
    const auto view = pose_of(images.pairs);
    ASSERT_TRUE(view);
    EXPECT_EQ(view->kind, PairKind::planar) << seed;
    if (view->pose.t.isZero(0)) {
      ASSERT_TRUE(view->R_other) << seed;
      EXPECT_LT(std::min(test::angle_between(view->pose.R, images.pose.R),
                         test::angle_between(*view->R_other, images.pose.R)),
                0.02)
          << seed;
      continue;
    }
    EXPECT_FALSE(view->R_other);
    ++told;
    EXPECT_LT(test::angle_between(view->pose.R, images.pose.R), 0.02) << seed;
    EXPECT_LT((view->pose.t - images.pose.t).norm(), 0.05) << seed;
  }
  EXPECT_GE(told, 5) << "points on both sides of a view tell more often than not";
}

TEST(RelativePose, NeedsEnoughThatFits) {
  EXPECT_FALSE(pose_of(two_images({.points = 14}).pairs));
  EXPECT_FALSE(pose_of(two_images({.points = 40, .wrong_share = 1}).pairs));
  EXPECT_TRUE(pose_of(two_images({.points = 15}).pairs));
}

}  // namespace
}  // namespace raybundle::init
