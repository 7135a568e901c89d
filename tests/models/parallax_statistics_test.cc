// Which points count as hardly placed: constructed cameras and points.

#include <raybundle/models/statistics.h>

#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

namespace raybundle {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;

// `count` cameras that look down -z, their centres `step` apart along z: they drive forwards.
Problem drive(int count, double step = 1) {
  Problem problem;
  for (int j = 0; j < count; ++j) {
    problem.cameras.insert(problem.cameras.end(), {0, 0, 0, 0, 0, j * step, 500, 0, 0});
  }
  return problem;
}

// A point that all cameras observe.
void add_seen_by_all(Problem& problem, double x, double y, double z) {
  const auto point = static_cast<std::int32_t>(problem.point_count());
  problem.points.insert(problem.points.end(), {x, y, z});
  for (std::int32_t j = 0; j < static_cast<std::int32_t>(problem.camera_count()); ++j) {
    problem.observation_camera.push_back(j);
    problem.observation_point.push_back(point);
    problem.observations.insert(problem.observations.end(), {0, 0});
  }
}

ParallaxStatistics of_point(Problem problem, double x, double y, double z) {
  add_seen_by_all(problem, x, y, z);
  return parallax_statistics(problem);
}

TEST(ParallaxStatistics, PointsOnTheLineOfMotionAreCollinear) {
  for (const int cameras : {2, 5, 40}) {  // 40: too many to compare pair by pair
    const double last = -(cameras - 1);
    const ParallaxStatistics ahead = of_point(drive(cameras), 0, 0, last - 20);
    EXPECT_EQ(ahead.collinear, 1) << cameras;
    EXPECT_EQ(ahead.low, 1);
    EXPECT_EQ(of_point(drive(cameras), 0, 0, 20).collinear, 1) << "behind them too";
    // As far to the side as the bound, seen from the last camera, and a bit more and less.
    const double side = 20 * std::tan(degree);
    EXPECT_EQ(of_point(drive(cameras), 0.99 * side, 0, last - 20).collinear, 1);
    EXPECT_EQ(of_point(drive(cameras), 1.01 * side, 0, last - 20).collinear, 0);
  }
}

TEST(ParallaxStatistics, BetweenItsObserversAPointIsCollinearWithAllParallax) {
  const ParallaxStatistics between = of_point(drive(2), 0, 0, -0.5);
  EXPECT_EQ(between.collinear, 1);
  EXPECT_EQ(between.low, 0) << "its rays are opposite";
}

TEST(ParallaxStatistics, FarPointsToTheSideAreLowButNotCollinear) {
  const ParallaxStatistics far = of_point(drive(5), 1e4, 0, -1e4);
  EXPECT_EQ(far.low, 1);
  EXPECT_EQ(far.collinear, 0);
  const ParallaxStatistics good = of_point(drive(5), 3, 1, -6);
  EXPECT_EQ(good.low, 0);
  EXPECT_EQ(good.collinear, 0);
}

TEST(ParallaxStatistics, OneObserverAsideIsEnough) {
  Problem problem = drive(4);
  problem.cameras[3] = -0.8;  // the first stands aside, and turns the line between the outer two
  EXPECT_EQ(of_point(problem, 0, 0, -25).collinear, 0);
}

TEST(ParallaxStatistics, WithoutMotionThereIsNoLine) {
  EXPECT_EQ(of_point(drive(4, 0), 0, 0, -10).collinear, 0);
  EXPECT_EQ(of_point(drive(4, 0), 0, 0, -10).low, 1);
  Problem one = drive(1);
  add_seen_by_all(one, 0, 0, -10);
  add_seen_by_all(one, 0, 0, -10);
  EXPECT_EQ(parallax_statistics(one).collinear, 0);
}

TEST(ParallaxStatistics, AreThoseOfTheStructure) {
  Problem problem = drive(3);
  add_seen_by_all(problem, 0, 0, -30);
  add_seen_by_all(problem, 1e4, 0, -1e4);
  add_seen_by_all(problem, 3, 1, -6);
  const StructureStatistics structure = structure_statistics(problem);
  EXPECT_EQ(structure.low_parallax_points, 2);
  EXPECT_EQ(structure.collinear_points, 1);
}

}  // namespace
}  // namespace raybundle
