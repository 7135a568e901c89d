// The incremental rival: it places what there is, and counts what it does.

#include <raybundle/solver/init/incremental.h>

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include <raybundle/models/alignment.h>
#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/sphere.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/tests/solver/init/forgotten.h>

namespace raybundle::init {
namespace {

using test::forgotten;

TEST(Incremental, PlacesImagesWithABundleAdjustmentForEachBatch) {
  for (const auto& scene : {scenes::street_scene({.cameras = 20, .points = 1200}),
                            scenes::sphere_scene({.cameras = 12, .points = 800, .region = 0.5})}) {
    const Problem seen = add_noise(scene, {.pixel_noise = 0.5, .outlier_share = 0.02}).problem;
    Problem problem = forgotten(seen);
    const IncrementalReport report = reconstruct_incrementally(problem, {});
    EXPECT_EQ(report.placed_images, problem.camera_count());
    EXPECT_GE(report.bundle_adjustments, 3);
    EXPECT_GE(report.resections, problem.camera_count() - 2);
    EXPECT_GT(report.placed_points, problem.point_count() / 2);
    const auto errors = compare_with_truth(problem, scene.truth);
    EXPECT_LT(errors.rotation_mean, 0.3) << "degrees";
    const Restriction part = placed_part(problem, report);
    EXPECT_EQ(part.problem.camera_count(), report.placed_images);
    EXPECT_EQ(part.problem.point_count(), report.placed_points);
  }
}

TEST(Incremental, HasTheSameBitsForAnyNumberOfThreads) {
  const scenes::Scene scene = scenes::street_scene({.cameras = 8, .points = 400});
  Problem one = forgotten(add_noise(scene, {.pixel_noise = 0.5}).problem), two = one;
  static_cast<void>(reconstruct_incrementally(one, {.threads = 1}));
  static_cast<void>(reconstruct_incrementally(two, {.threads = 2}));
  EXPECT_EQ(one.cameras, two.cameras);
  EXPECT_EQ(one.points, two.points);
}

TEST(Incremental, SaysSoWhereThereIsNoPairToBeginWith) {
  Problem problem = scenes::street_scene({.cameras = 2, .points = 10}).truth;
  const Problem before = problem;
  const IncrementalReport report = reconstruct_incrementally(problem, {});
  EXPECT_EQ(report.conclusion.ending, Ending::no_pose);
  EXPECT_EQ(report.bundle_adjustments, 0);
  EXPECT_EQ(problem.cameras, before.cameras);
}

// Where no pair makes points of enough parallax every seed is given up, and nothing stays behind.
TEST(Incremental, GivesUpSeedsWithoutParallax) {
  Problem problem = scenes::street_scene({.cameras = 8, .points = 400}).truth;
  const Problem before = problem;
  const IncrementalReport report =
      reconstruct_incrementally(problem, {.triangulation = {.min_parallax = 3}});
  EXPECT_EQ(report.conclusion.ending, Ending::no_pose);
  EXPECT_EQ(report.placed_images, 0);
  EXPECT_EQ(problem.cameras, before.cameras);
  EXPECT_EQ(problem.points, before.points);
}

TEST(Incremental, StopsWhereItIsTold) {
  Problem problem = scenes::street_scene({.cameras = 8, .points = 400}).truth;
  const auto stop = [](const char* stage, std::int64_t, std::int64_t) {
    return std::string(stage) == "images" ? Control::stop : Control::proceed;
  };
  const IncrementalReport report = reconstruct_incrementally(problem, {}, stop);
  EXPECT_EQ(report.conclusion.ending, Ending::interrupted);
  EXPECT_EQ(report.placed_images, 2);
}

}  // namespace
}  // namespace raybundle::init
