// The incremental rival: it places what there is, and counts what it does.

#include <raybundle/solver/init/incremental.h>

#include <algorithm>

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

}  // namespace
}  // namespace raybundle::init
