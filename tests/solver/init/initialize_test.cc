// From observations alone: scenes of every kind come out close to their truth.

#include <raybundle/solver/init/initialize.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/alignment.h>
#include <raybundle/models/error.h>
#include <raybundle/models/scenes/aerial.h>
#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/photos.h>
#include <raybundle/models/scenes/sphere.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/solver/solve.h>
#include <raybundle/tests/solver/init/forgotten.h>

namespace raybundle::init {
namespace {

using test::forgotten;

struct Kind {
  std::string name;
  scenes::Scene scene;
};

std::vector<Kind> kinds() {
  return {{"street", scenes::street_scene({.cameras = 30, .points = 1500})},
          {"sphere", scenes::sphere_scene({.cameras = 15, .points = 800, .region = 0.5})},
          {"aerial", scenes::aerial_scene({.cameras = 30, .points = 1500})},
          {"photos", scenes::photos_scene({.cameras = 30, .points = 1500, .observations = 9000})}};
}

TEST(Initialize, ReachesTheCostOfTheTruth) {
  for (const Kind& kind : kinds()) {
    const Problem seen = add_noise(kind.scene, {.pixel_noise = 1}).problem;
    Problem found = forgotten(seen);
    const InitializeReport report = initialize(found, {});
    EXPECT_EQ(report.placed_images, found.camera_count()) << kind.name;
    if (report.placed_images < found.camera_count()) continue;
    Problem best = seen;
    const Options options = {.lens = Lens::fixed};
    const double least = solve(best, options).final_cost;
    const double cost = solve(found, options).final_cost;
    EXPECT_LT(cost, 1.01 * least) << kind.name;
  }
}

TEST(Initialize, ReachesTheCostOfTheTruthAmongWrongMatches) {
  for (const Kind& kind : kinds()) {
    const Problem seen = add_noise(kind.scene, {.outlier_share = 0.05}).problem;
    Problem found = forgotten(seen);
    const InitializeReport report = initialize(found, {});
    ASSERT_EQ(report.placed_images, found.camera_count()) << kind.name;
    EXPECT_GT(report.disagreeing_observations, seen.observation_count() / 50) << kind.name;
    EXPECT_LT(report.disagreeing_observations, seen.observation_count() / 10) << kind.name;
    Problem best = seen;
    const Options options = {.lens = Lens::fixed, .loss = Loss::cauchy, .loss_scale = 2.0};
    const double least = solve(best, options).final_cost;
    EXPECT_LT(solve(found, options).final_cost, 1.02 * least) << kind.name;
  }
}

TEST(Initialize, HasTheSameBitsForAnyNumberOfThreads) {
  const scenes::Scene scene = scenes::street_scene({.cameras = 12, .points = 400});
  Problem one = forgotten(add_noise(scene, {}).problem), two = one;
  static_cast<void>(initialize(one, {.threads = 1}));
  static_cast<void>(initialize(two, {.threads = 2}));
  EXPECT_EQ(one.cameras, two.cameras);
  EXPECT_EQ(one.points, two.points);
}

TEST(Initialize, KeepsTheLargestPartAndSaysWhatBecameOfTheRest) {
  const scenes::Scene scene = scenes::street_scene({.cameras = 20, .points = 800});
  Problem problem = forgotten(add_noise(scene, {.pixel_noise = 0.5}).problem);
  // Nothing that the last five see is seen by the others.
  std::vector<std::uint8_t> of_late(static_cast<std::size_t>(problem.point_count()), 0);
  for (std::size_t k = 0; k < problem.observation_camera.size(); ++k) {
    if (problem.observation_camera[k] >= 15) {
      of_late[static_cast<std::size_t>(problem.observation_point[k])] = 1;
    }
  }
  Problem cut = test::thinned(problem, [&](std::int32_t camera, std::int32_t point) {
    return camera >= 15 || of_late[static_cast<std::size_t>(point)] == 0;
  });
  const InitializeReport report = initialize(cut, {});
  for (std::size_t i = 15; i < 20; ++i) EXPECT_EQ(report.images[i], Placement::apart) << i;
  EXPECT_GE(report.placed_images, 12);
  EXPECT_EQ(cut.cameras[9 * 17 + 3], 0) << "left as it was";
  EXPECT_EQ(placed_part(cut, report).problem.camera_count(), report.placed_images);
}

// An image with fewer points than a pair needs is put where it sees them.
TEST(Initialize, ResectsImagesThatNoPairPlaces) {
  const scenes::Scene scene = scenes::sphere_scene({.cameras = 10, .points = 400, .region = 0.5});
  const Problem seen = add_noise(scene, {.pixel_noise = 0.5}).problem;
  int left = 15;
  Problem problem = forgotten(test::thinned(
      seen, [&](std::int32_t camera, std::int32_t) { return camera != 4 || left-- > 0; }));
  const InitializeReport report = initialize(problem, {});
  EXPECT_EQ(report.images[4], Placement::resected);
  EXPECT_EQ(report.resected_images, 1);
  EXPECT_EQ(report.placed_images, 10);
  EXPECT_LT(compare_with_truth(problem, scene.truth).rotation_mean, 0.5) << "degrees";
  EXPECT_EQ(placed_part(problem, report).problem.camera_count(), 10);
}

TEST(Initialize, SaysSoWhereNoTwoImagesHaveAPose) {
  Problem problem = scenes::street_scene({.cameras = 2, .points = 10}).truth;
  const Problem before = problem;
  const InitializeReport report = initialize(problem, {});
  EXPECT_EQ(report.conclusion.ending, Ending::no_pose);
  EXPECT_NE(report.conclusion.message.find("20 points"), std::string::npos);
  EXPECT_EQ(problem.cameras, before.cameras);
  EXPECT_EQ(placed_part(problem, report).problem.camera_count(), 0);
}

// Turning about one place has rotations, and no positions.
TEST(Initialize, KeepsTheRotationsOfAPanorama) {
  scenes::Scene scene = scenes::sphere_scene({.cameras = 6, .points = 300, .region = 0.2});
  const auto R_cw = camera_rotations(scene.truth);
  const std::vector<double> centres = camera_centres(scene.truth);
  const Eigen::Vector3d centre(centres[0], centres[1], centres[2]);
  for (std::size_t i = 0; i < R_cw.size(); ++i) {
    Eigen::Map<Eigen::Vector3d>(scene.truth.cameras.data() + 9 * i + 3) = -R_cw[i] * centre;
  }
  scene.truth = test::seen_exactly(scene.truth);
  Problem problem = forgotten(add_noise(scene, {.pixel_noise = 0.3}).problem);
  const InitializeReport report = initialize(problem, {});
  EXPECT_EQ(report.conclusion.ending, Ending::no_parallax);
  EXPECT_EQ(report.rotation_edges, report.edges);
  EXPECT_EQ(std::count(report.images.begin(), report.images.end(), Placement::unmeasured), 6);
  EXPECT_LT(report.rotations.after.largest, 0.01);
  EXPECT_EQ(std::count(report.rotations.known.begin(), report.rotations.known.end(), 1), 6);
}

TEST(Initialize, RefusesWhatIsFixedAndCountsWhatIsRepeated) {
  Problem problem = scenes::street_scene({.cameras = 8, .points = 300}).truth;
  problem.fixed_points.assign(300, 0);
  problem.fixed_points[7] = 1;
  EXPECT_THROW(initialize(problem, {}), InputError);
  problem.fixed_points.clear();
  problem.fixed_camera_parameters.assign(8, 0b111000000);  // lenses: they stay anyway
  problem.observation_camera.push_back(problem.observation_camera[5]);
  problem.observation_point.push_back(problem.observation_point[5]);
  problem.observations.insert(problem.observations.end(), {1, 1});
  const InitializeReport report = initialize(problem, {});
  EXPECT_EQ(report.conclusion.ending, Ending::placed);
  EXPECT_EQ(report.repeated_observations, 1);
  EXPECT_EQ(report.impossible_observations, 0);
  EXPECT_EQ(report.observations.back(), 0);
}

TEST(Initialize, StopsWhereItIsTold) {
  const scenes::Scene scene = scenes::street_scene({.cameras = 10, .points = 500});
  for (const std::string at : {"pairs", "rotations", "positions"}) {
    Problem problem = forgotten(scene.truth);
    const auto stop_there = [&](const char* stage, std::int64_t, std::int64_t) {
      return stage == at ? Control::stop : Control::proceed;
    };
    const InitializeReport report = initialize(problem, {}, stop_there);
    EXPECT_EQ(report.conclusion.ending, Ending::interrupted) << at;
    EXPECT_NE(report.conclusion.message.find(at), std::string::npos);
    EXPECT_EQ(report.placed_images, at == "positions" ? 10 : 0) << at;
  }
}

TEST(Initialize, PlacesTwoImagesAndAFlatScene) {
  scenes::Scene two = scenes::sphere_scene({.cameras = 2, .points = 200, .region = 0.5});
  Problem pair = forgotten(add_noise(two, {.pixel_noise = 0.5}).problem);
  EXPECT_EQ(initialize(pair, {}).placed_images, 2);

  scenes::Scene flat = scenes::aerial_scene({.cameras = 20, .points = 800, .height = 2});
  for (std::size_t p = 2; p < flat.truth.points.size(); p += 3) flat.truth.points[p] = 0;
  flat.truth = test::seen_exactly(flat.truth);
  const Problem seen = add_noise(flat, {.pixel_noise = 0.5}).problem;
  Problem problem = forgotten(seen), best = seen;
  const InitializeReport report = initialize(problem, {});
  EXPECT_GT(report.planar_edges, report.edges / 2);
  ASSERT_EQ(report.placed_images, 20);
  const Options options = {.lens = Lens::fixed};
  const double least = solve(best, options).final_cost;
  EXPECT_LT(solve(problem, options).final_cost, 1.01 * least);
}

}  // namespace
}  // namespace raybundle::init
