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
  Problem cut = problem;
  cut.observation_camera.clear(), cut.observation_point.clear(), cut.observations.clear();
  for (std::size_t k = 0; k < problem.observation_camera.size(); ++k) {
    if (problem.observation_camera[k] >= 15) {
      of_late[static_cast<std::size_t>(problem.observation_point[k])] = 1;
    }
  }
  for (std::size_t k = 0; k < problem.observation_camera.size(); ++k) {
    const bool late = problem.observation_camera[k] >= 15;
    if (!late && of_late[static_cast<std::size_t>(problem.observation_point[k])] != 0) continue;
    cut.observation_camera.push_back(problem.observation_camera[k]);
    cut.observation_point.push_back(problem.observation_point[k]);
    cut.observations.insert(cut.observations.end(),
                            {problem.observations[2 * k], problem.observations[2 * k + 1]});
  }
  const InitializeReport report = initialize(cut, {});
  for (std::size_t i = 15; i < 20; ++i) EXPECT_EQ(report.images[i], Placement::apart) << i;
  EXPECT_GE(report.placed_images, 12);
  EXPECT_EQ(cut.cameras[9 * 17 + 3], 0) << "left as it was";
  EXPECT_EQ(placed_part(cut, report).problem.camera_count(), report.placed_images);
}

TEST(Initialize, RefusesWhatNoTwoImagesTell) {
  const scenes::Scene scene = scenes::street_scene({.cameras = 2, .points = 10});
  Problem problem = scene.truth;
  EXPECT_THROW(initialize(problem, {}), InputError);
}

}  // namespace
}  // namespace raybundle::init
