// Which pairs of images are tried, and which pair a point is described by.

#include <raybundle/solver/init/features.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/alignment.h>
#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/sphere.h>
#include <raybundle/solver/init/image_pairs.h>
#include <raybundle/tests/solver/init/true_graph.h>

namespace raybundle::init {
namespace {

// Two groups of images, the first half and the rest: `within` points are seen by all of a group,
// `across` by the first image of each.
Problem two_groups(std::int32_t images, std::int32_t within, std::int32_t across) {
  Problem problem;
  problem.cameras.assign(static_cast<std::size_t>(9 * images), 0);
  for (std::int32_t i = 0; i < images; ++i)
    problem.cameras[static_cast<std::size_t>(9 * i + 6)] = 500;
  const auto see = [&](std::int32_t image, std::int32_t point) {
    problem.observation_camera.push_back(image);
    problem.observation_point.push_back(point);
    problem.observations.insert(problem.observations.end(), {1.0 * image, 1.0 * point});
  };
  std::int32_t point = 0;
  for (std::int32_t group = 0; group < 2; ++group) {
    for (std::int32_t k = 0; k < within; ++k, ++point) {
      for (std::int32_t i = 0; i < images / 2; ++i) see(group * images / 2 + i, point);
    }
  }
  for (std::int32_t k = 0; k < across; ++k, ++point) see(0, point), see(images / 2, point);
  problem.points.assign(static_cast<std::size_t>(3 * point), 0);
  return problem;
}

TEST(ImagePairs, AreThoseWithMostInCommonAndWhatConnectsThem) {
  linalg::ThreadPool one(1), two(2);
  const Problem problem = two_groups(12, 50, 30);
  const Sightings sightings(problem, one);
  const PairOptions options = {.min_common = 20, .most_per_image = 2};
  const auto pairs = image_pairs(sightings, options, one);
  std::set<std::pair<int, int>> found;
  for (const ImagePair& pair : pairs) {
    EXPECT_LT(pair.i, pair.j);
    EXPECT_TRUE(found.emplace(pair.i, pair.j).second) << "twice";
    EXPECT_EQ(pair.common, pair.j < 6 || pair.i >= 6 ? 50 : 30);
  }
  EXPECT_TRUE(found.contains({0, 6})) << "nobody asks for it, but it connects";
  EXPECT_LT(pairs.size(), 40U) << "of 31";
  EXPECT_EQ(image_pairs(sightings, options, two).size(), pairs.size());
  EXPECT_EQ(image_pairs(sightings, {.min_common = 31, .most_per_image = 40}, one).size(), 30U);
}

TEST(Features, AreAnchoredInObserversThatAgree) {
  linalg::ThreadPool pool(2);
  const scenes::Scene scene = scenes::sphere_scene({.cameras = 10, .points = 400, .region = 0.5});
  Problem seen = scene.truth;
  // One sighting of each point that at least four images see is moved along its epipolar line with
  // the track's first image, or anywhere.
  Sightings right(seen, pool);
  std::vector<std::int64_t> wrong;
  for (std::int64_t p = 0; p < right.points(); ++p) {
    const Sightings::Range track = right.of_point(p);
    if (track.size() < 4) continue;
    wrong.push_back(track.first + 1);
    const auto k = static_cast<std::size_t>(right.observation(track.first + 1));
    seen.observations[2 * k] += 40;
    seen.observations[2 * k + 1] -= 25;
  }
  ASSERT_GT(wrong.size(), 100U);
  const Sightings sightings(seen, pool);
  const auto R_cw = camera_rotations(scene.truth);
  const std::vector<std::uint8_t> known(R_cw.size(), 1);
  const auto graph = test::true_graph(scene.truth, sightings, pool);
  const Features found = features(sightings, graph, R_cw, known, 2, pool);
  std::int64_t marked = 0, anchored = 0;
  for (const std::int64_t s : wrong) marked += found.disagreeing[static_cast<std::size_t>(s)];
  for (const Feature& feature : found.all) {
    for (const std::int64_t s : wrong) {
      if (sightings.point(s) != feature.point) continue;
      anchored += sightings.image(s) == feature.main || sightings.image(s) == feature.associate;
    }
  }
  EXPECT_LT(anchored, static_cast<std::int64_t>(wrong.size()) / 50);
  EXPECT_GT(marked, static_cast<std::int64_t>(wrong.size()) / 2);
  const auto all = std::count(found.disagreeing.begin(), found.disagreeing.end(), 1);
  EXPECT_LE(all, marked) << "right ones are not marked";
}

}  // namespace
}  // namespace raybundle::init
