#include <raybundle/models/scenes/sphere.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include <raybundle/models/error.h>
#include <raybundle/models/scenes/camera.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/models/scene_hash.h>

namespace raybundle::scenes {
namespace {

using test::hash;

TEST(Sphere, IsPinned) {
  // Must hold for every compiler, machine and set of flags.
  EXPECT_EQ(hash(sphere_scene().truth), 0x7130B5A4789A38E1U);
  EXPECT_EQ(hash(sphere_scene({.seed = 9, .observations = 1834}).truth), 0x0C0698235EA60010U);
}

TEST(Sphere, HasTheCountsAskedFor) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Scene scene =
        sphere_scene({.seed = seed, .cameras = 50, .points = 1000, .observations = 28991});
    const StructureStatistics s = structure_statistics(scene.truth);
    EXPECT_EQ(s.cameras, 50);
    EXPECT_EQ(s.points, 1000);
    EXPECT_EQ(s.observations, 28991);
    EXPECT_EQ(s.components, 1);
    EXPECT_EQ(s.unobserved_points + s.points_seen_once + s.duplicate_observations, 0);
    EXPECT_GE(s.fewest_observations, 200);
    EXPECT_NO_THROW(validate(scene.truth));
  }
}

TEST(Sphere, ReachesSparseAndDenseScenes) {
  for (const std::int64_t observations : {2600, 4000, 8000, 20000, 28000}) {
    const Scene scene = sphere_scene({.cameras = 40, .points = 1000, .observations = observations});
    EXPECT_EQ(scene.truth.observation_count(), observations);
  }
}

TEST(Sphere, CamerasAndPointsAreWhereTheThesisWantsThem) {
  const Scene scene = sphere_scene({.cameras = 60, .points = 500, .region = 3});
  const Problem& truth = scene.truth;
  for (std::int64_t i = 0; i < truth.point_count(); ++i) {
    EXPECT_NEAR(norm(point_of(truth, i)), 500, 1e-9);
  }
  for (std::int64_t j = 0; j < truth.camera_count(); ++j) {
    const View view(camera_of(truth, j));
    const Vec3& centre = view.camera().centre;
    EXPECT_GT(norm(centre), 500);
    EXPECT_LT(view.camera().f, 500);
    EXPECT_NEAR(view.camera().k1, 1e-2, 1e-2);
    EXPECT_NEAR(view.camera().k2, 1e-4, 1e-4);
    EXPECT_GT(dot(view.axes().z, centre) / norm(centre), std::cos(3.14159266 / 6));
  }
  for (std::int64_t k = 0; k < truth.observation_count(); ++k) {
    const auto at = static_cast<std::size_t>(k);
    const Vec3 X = point_of(truth, truth.observation_point[at]);
    const Vec3 centre = camera_of(truth, truth.observation_camera[at]).centre;
    EXPECT_GT(dot(X, difference(centre, X)), 0);  // on the near side of the ball
    EXPECT_LE(std::abs(truth.observations[2 * at]), 400);
    EXPECT_LE(std::abs(truth.observations[2 * at + 1]), 300);
  }
}

TEST(Sphere, NeighboursInTheOrderOverlap) {
  // The mean distance of successive cameras is far below that of any two.
  const Problem truth = sphere_scene({.cameras = 100, .points = 100, .region = 3}).truth;
  double successive = 0, any = 0;
  for (std::int64_t j = 0; j < 99; ++j) {
    const Vec3 here = camera_of(truth, j).centre;
    successive += norm(difference(camera_of(truth, j + 1).centre, here)) / 99;
    any += norm(difference(camera_of(truth, (j + 50) % 100).centre, here)) / 99;
  }
  EXPECT_LT(successive, 0.4 * any);
}

TEST(Sphere, IsExact) {
  const Problem truth = sphere_scene({.cameras = 30}).truth;
  EXPECT_LT(reprojection_statistics(truth).largest, 1e-9);
  EXPECT_EQ(reprojection_statistics(truth).behind_camera, 0);
}

TEST(Sphere, RefusesWhatCannotBe) {
  EXPECT_THROW(sphere_scene({.cameras = 1}), InputError);
  EXPECT_THROW(sphere_scene({.points = 0}), InputError);
  EXPECT_THROW(sphere_scene({.observations = 577}), InputError);
  EXPECT_THROW(sphere_scene({.observations = 2891}), InputError);
  EXPECT_THROW(sphere_scene({.observations = -1}), InputError);
  EXPECT_THROW(sphere_scene({.region = 4}), InputError);
  EXPECT_THROW(sphere_scene({.region = std::nan("")}), InputError);
}

}  // namespace
}  // namespace raybundle::scenes
