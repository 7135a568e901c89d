#include <raybundle/models/statistics.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/io/bal.h>
#include <raybundle/models/random.h>
#include <raybundle/models/scenes/street.h>

namespace raybundle {
namespace {

void append_camera(Problem& problem, const std::vector<double>& camera) {
  problem.cameras.insert(problem.cameras.end(), camera.begin(), camera.end());
}

void append_point(Problem& problem, double x, double y, double z) {
  problem.points.insert(problem.points.end(), {x, y, z});
}

void observe(Problem& problem, std::int32_t camera, std::int32_t point, double x = 0,
             double y = 0) {
  problem.observation_camera.push_back(camera);
  problem.observation_point.push_back(point);
  problem.observations.insert(problem.observations.end(), {x, y});
}

/// Cameras one step apart along x that look down -z, points far ahead; nothing observed yet.
Problem row_of_cameras(int cameras, int points) {
  Problem problem;
  for (int j = 0; j < cameras; ++j) append_camera(problem, {0, 0, 0, -1.0 * j, 0, 0, 1, 0, 0});
  for (int i = 0; i < points; ++i) append_point(problem, i, 0, -10);
  return problem;
}

TEST(ReprojectionStatistics, MatchesAHandComputedProjection) {
  Problem problem;
  // Half a turn about y: X_c = (-X, Y, -Z) + t. (1, 2, 5) becomes (-1, 2, -5) + (3, 0, 1).
  append_camera(problem, {0, 3.14159265358979323846, 0, 3, 0, 1, 100, 0.5, 0.25});
  append_point(problem, 1, 2, 5);
  append_point(problem, 1, 2, -3);  // X_c.z = 4: behind
  const double p = 0.5;             // p = (2, 2) / 4, |p|^2 = 0.5
  const double u = 100 * (1 + 0.5 * 0.5 + 0.25 * 0.25) * p;
  observe(problem, 0, 0, u - 3, u + 4);
  const ReprojectionStatistics one = reprojection_statistics(problem);
  EXPECT_NEAR(one.cost, 12.5, 1e-11);
  EXPECT_NEAR(one.rmse, 5, 1e-12);
  EXPECT_NEAR(one.largest, 5, 1e-12);
  EXPECT_EQ(one.behind_camera, 0);

  observe(problem, 0, 1, -u, -u);
  const ReprojectionStatistics two = reprojection_statistics(problem);
  EXPECT_NEAR(two.cost, 12.5, 1e-11);
  EXPECT_NEAR(two.rmse, std::sqrt(12.5), 1e-12);
  EXPECT_EQ(two.behind_camera, 1);
}

TEST(ReprojectionStatistics, OfNothingIsZero) {
  const ReprojectionStatistics none = reprojection_statistics(row_of_cameras(2, 3));
  EXPECT_EQ(none.cost, 0);
  EXPECT_EQ(none.rmse, 0);
  EXPECT_EQ(none.largest, 0);
}

TEST(ReprojectionStatistics, APointInTheCameraPlaneGivesNoFiniteCost) {
  Problem problem = row_of_cameras(1, 1);
  problem.points[2] = 0;
  observe(problem, 0, 0, 1, 1);
  EXPECT_FALSE(std::isfinite(reprojection_statistics(problem).cost));
  EXPECT_EQ(reprojection_statistics(problem).behind_camera, 1);
}

TEST(ReprojectionStatistics, SumsWithFullPrecision) {
  // A million equal squares: adding them one after the other is off by more than this.
  Problem problem = row_of_cameras(1, 1);
  problem.points[2] = -10;
  for (int k = 0; k < 1000000; ++k) observe(problem, 0, 0, 0.1, 0);
  const double expected = 0.5 * (0.1 * 0.1) * 1e6;
  EXPECT_NEAR(reprojection_statistics(problem).cost, expected, 1e-14 * expected);
}

TEST(ReprojectionBreakdown, AddsUpToTheWhole) {
  const Problem problem = scenes::street({.seed = 2, .cameras = 8, .points = 200});
  const ReprojectionStatistics whole = reprojection_statistics(problem);
  const ReprojectionBreakdown parts = reprojection_breakdown(problem);
  ASSERT_EQ(parts.cameras.size(), 8U);
  ASSERT_EQ(parts.points.size(), 200U);
  for (const auto& list : {parts.cameras, parts.points}) {
    std::int64_t observations = 0;
    double squares = 0, largest = 0;
    for (const ResidualSummary& each : list) {
      observations += each.observations;
      squares += each.rmse * each.rmse * static_cast<double>(each.observations);
      largest = std::max(largest, each.largest);
      EXPECT_LE(each.rmse, each.largest * (1 + 1e-14));
    }
    EXPECT_EQ(observations, problem.observation_count());
    EXPECT_NEAR(squares / 2, whole.cost, 1e-12 * whole.cost);
    EXPECT_EQ(largest, whole.largest);
  }
}

TEST(ReprojectionBreakdown, GivesToEachWhatIsItsOwn) {
  Problem problem = row_of_cameras(3, 3);  // camera j projects point i to (i - j) / 10
  observe(problem, 0, 0, 3, 4);            // 5 pixels
  observe(problem, 1, 1, 0, 12);           // 12
  observe(problem, 1, 0, -0.1, -5);        // 5
  const ReprojectionBreakdown parts = reprojection_breakdown(problem);
  EXPECT_EQ(parts.cameras[1].observations, 2);
  EXPECT_NEAR(parts.cameras[1].rmse, std::sqrt(169.0 / 2), 1e-13);
  EXPECT_NEAR(parts.cameras[1].largest, 12, 1e-13);
  EXPECT_NEAR(parts.cameras[0].rmse, 5, 1e-13);
  EXPECT_EQ(parts.points[0].observations, 2);
  EXPECT_NEAR(parts.points[0].rmse, 5, 1e-13);
  EXPECT_EQ(parts.cameras[2].observations, 0);
  EXPECT_EQ(parts.cameras[2].rmse, 0);
  EXPECT_EQ(parts.points[2].largest, 0);
}

// A camera at the origin with f = 100 that sees points at depth 1.
TEST(RobustStatistics, CountsWhatIsWithinTheScale) {
  Problem problem;
  problem.cameras = {0, 0, 0, 0, 0, 0, 100, 0, 0};
  for (const double error : {0.5, 3.0, -4.0, 1.0}) {
    problem.observation_camera.push_back(0);
    problem.observation_point.push_back(static_cast<std::int32_t>(problem.points.size() / 3));
    problem.points.insert(problem.points.end(), {0, 0, -1});
    problem.observations.insert(problem.observations.end(), {error, 0});
  }
  EXPECT_EQ(robust_statistics(problem, 3).within, 3);
  EXPECT_EQ(robust_statistics(problem, 0.9).within, 1);
  EXPECT_EQ(robust_statistics(problem, 1).median, 3);
  problem.points[2] = problem.points[11] = 0;  // in the plane of the camera
  EXPECT_EQ(robust_statistics(problem, 1e100).within, 2);
  EXPECT_EQ(robust_statistics(problem, 1).median, std::numeric_limits<double>::infinity());
  EXPECT_EQ(robust_statistics({}, 1).median, 0);
}

TEST(StructureStatistics, CountsWhatIsThere) {
  Problem problem = row_of_cameras(6, 6);
  observe(problem, 0, 0);  // point 0: three cameras
  observe(problem, 1, 0);
  observe(problem, 2, 0);
  observe(problem, 1, 2);  // point 2: one camera, twice
  observe(problem, 1, 2);
  observe(problem, 3, 3);  // point 3: another island, with a duplicate
  observe(problem, 5, 3);
  observe(problem, 3, 3);
  observe(problem, 2, 5);  // point 5: a pair that occurred before
  observe(problem, 1, 5);
  const StructureStatistics s = structure_statistics(problem);
  EXPECT_EQ(s.cameras, 6);
  EXPECT_EQ(s.points, 6);
  EXPECT_EQ(s.observations, 10);
  EXPECT_EQ(s.unobserved_cameras, 1);
  EXPECT_EQ(s.first_unobserved_camera, 4);
  EXPECT_EQ(s.unobserved_points, 2);
  EXPECT_EQ(s.first_unobserved_point, 1);
  EXPECT_EQ(s.points_seen_once, 1);
  EXPECT_EQ(s.first_point_seen_once, 2);
  EXPECT_EQ(s.duplicate_observations, 2);
  EXPECT_EQ(s.first_duplicate_camera, 1);
  EXPECT_EQ(s.first_duplicate_point, 2);
  EXPECT_EQ(s.components, 2);
  EXPECT_EQ(s.largest_component, 3);
  EXPECT_EQ(s.camera_pairs, 4);  // 01 02 12 35
  EXPECT_EQ(s.longest_track, 3);
  EXPECT_DOUBLE_EQ(s.mean_track_length, 2.5);
  EXPECT_EQ(s.fewest_observations, 1);
  EXPECT_EQ(s.most_observations, 4);
  EXPECT_EQ(s.low_parallax_points, 0);
}

TEST(StructureStatistics, OfAnEmptyProblemIsZero) {
  const StructureStatistics s = structure_statistics(Problem{});
  EXPECT_EQ(s.components, 0);
  EXPECT_EQ(s.camera_pairs, 0);
  EXPECT_EQ(s.mean_track_length, 0);
  EXPECT_TRUE(warnings(s).empty());
}

/// Random observations: short tracks, and long ones that are counted by sets of bits.
Problem random_observations(int cameras, int points, int longest, std::uint64_t seed) {
  Problem problem = row_of_cameras(cameras, points);
  Random random(seed);
  for (std::int32_t i = 0; i < points; ++i) {
    const std::int64_t length = random.uniform() < 0.2 ? random.below(longest) : random.below(3);
    for (std::int64_t k = 0; k < length; ++k) {
      observe(problem, static_cast<std::int32_t>(random.below(cameras)), i);
    }
  }
  return problem;
}

TEST(StructureStatistics, CameraPairsMatchASetOfPairs) {
  for (const int cameras : {1, 2, 63, 64, 65, 130, 400}) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const Problem problem = random_observations(cameras, 60, 12, seed);
      std::set<std::pair<int, int>> pairs;
      for (std::size_t a = 0; a < problem.observation_camera.size(); ++a) {
        for (std::size_t b = 0; b < problem.observation_camera.size(); ++b) {
          if (problem.observation_point[a] != problem.observation_point[b]) continue;
          const int i = problem.observation_camera[a];
          const int j = problem.observation_camera[b];
          if (i < j) pairs.emplace(i, j);
        }
      }
      EXPECT_EQ(structure_statistics(problem).camera_pairs, static_cast<std::int64_t>(pairs.size()))
          << cameras << " cameras, seed " << seed;
    }
  }
}

TEST(StructureStatistics, LowParallaxIsBelowOneDegree) {
  // Seen from two cameras one step apart, the angle is 2 atan(1 / (2 depth)): 1 degree at 57.29.
  for (const int cameras : {2, 40}) {  // 40: all but the last at the same place
    Problem problem;
    for (int j = 0; j < cameras; ++j) {
      append_camera(problem, {0, 0, 0, j + 1 < cameras ? 0.0 : -1.0, 0, 0, 1, 0, 0});
    }
    append_point(problem, 0.5, 0, -57.0);
    append_point(problem, 0.5, 0, -57.6);
    append_point(problem, 0.5, 0, 1e200);  // as good as parallel
    append_point(problem, 0, 0, 0);        // at a camera's centre: that ray has no direction
    for (std::int32_t i = 0; i < 4; ++i) {
      for (std::int32_t j = 0; j < cameras; ++j) observe(problem, j, i);
    }
    EXPECT_EQ(structure_statistics(problem).low_parallax_points, 3) << cameras << " cameras";
  }
}

TEST(StructureStatistics, ParallaxOfOneCameraIsNotCounted) {
  Problem problem = row_of_cameras(1, 1);
  observe(problem, 0, 0);
  observe(problem, 0, 0);
  EXPECT_EQ(structure_statistics(problem).low_parallax_points, 0);
  EXPECT_EQ(structure_statistics(problem).points_seen_once, 1);
}

TEST(Warnings, ArePlainSentences) {
  StructureStatistics s;
  EXPECT_TRUE(warnings(s).empty());
  s.unobserved_cameras = 2;
  s.first_unobserved_camera = 17;
  s.unobserved_points = 1;
  s.first_unobserved_point = 4;
  s.points_seen_once = 3;
  s.first_point_seen_once = 8;
  s.duplicate_observations = 1;
  s.first_duplicate_camera = 5;
  s.first_duplicate_point = 6;
  s.components = 2;
  s.largest_component = 30;
  const std::vector<std::string> expected = {
      "2 cameras have no observations and stay as they are (first: camera 17)",
      "1 point is not observed and stays as it is (first: point 4)",
      "3 points are observed by one camera only: their depth is not determined (first: point 8)",
      "1 observation repeats a camera and point that occurred before; all count (first: camera 5, "
      "point 6)",
      "the cameras fall into 2 sets that share no points (largest: 30 cameras): their places "
      "relative to one another are not determined"};
  EXPECT_EQ(warnings(s), expected);
}

struct KnownFile {
  const char* name;
  double cost;
  std::int64_t behind;
};

class BalFile : public ::testing::TestWithParam<KnownFile> {};

TEST_P(BalFile, HasTheKnownCost) {
  const std::filesystem::path path =
      std::filesystem::path(RAYBUNDLE_DATA_DIR) / "bal" / GetParam().name;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no data at " << path;
  const ReprojectionStatistics result = reprojection_statistics(io::read_bal(path));
  EXPECT_NEAR(result.cost, GetParam().cost,
              0.5e-6 * std::pow(10, std::floor(std::log10(result.cost))));
  EXPECT_EQ(result.behind_camera, GetParam().behind);
}

// Costs to seven digits, from an independent computation.
INSTANTIATE_TEST_SUITE_P(Known, BalFile,
                         ::testing::Values(KnownFile{"problem-49-7776-pre.txt", 8.509125e5, 31},
                                           KnownFile{"problem-21-11315-pre.txt", 4.413239e6, 0},
                                           KnownFile{"problem-16-22106-pre.txt", 4.185660e6, 0}),
                         [](const auto& parameter) {
                           return "File" + std::to_string(parameter.index);
                         });

}  // namespace
}  // namespace raybundle
