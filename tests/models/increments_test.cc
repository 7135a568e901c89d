// The search for increments against finite differences made by hand.

#include <raybundle/models/increments.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/error.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

constexpr std::size_t focal = 2, k1 = 3, k2 = 4;

IncrementSearch search(const Problem& problem, int threads = 2,
                       PointModel points = PointModel::xyz) {
  linalg::ThreadPool pool(threads);
  return search_increments(problem, points, pool);
}

double least(const std::vector<IncrementTrial>& trials) {
  double error = std::numeric_limits<double>::infinity();
  for (const IncrementTrial& trial : trials) error = std::min(error, trial.error);
  return error;
}

TEST(Increments, TruncationAndRoundingMeet) {
  const IncrementSearch found = search(test::small_problem({.seed = 3}));
  for (std::size_t kind = 0; kind < found.trials.size(); ++kind) {
    const auto& trials = found.trials[kind];
    if (!has_kind(PointModel::xyz, static_cast<ParameterKind>(kind))) {
      EXPECT_TRUE(trials.empty());
      continue;
    }
    ASSERT_EQ(trials.size(), 13U);
    EXPECT_EQ(trials.front().step, 1);
    if (kind == focal || kind == k1 || kind == k2) continue;
    // Forward differences: the error falls in proportion to the step while truncation rules it.
    EXPECT_NEAR(trials[4].error / trials[5].error, 10, 0.5) << kind;
    EXPECT_GT(trials.back().error, 100 * least(trials)) << "rounding rules the smallest steps";
  }
}

// The projection is linear in these: a larger step only gains.
TEST(Increments, TheLensHasNoTruncation) {
  const IncrementSearch found = search(test::small_problem({.seed = 3}));
  for (const std::size_t kind : {focal, k1, k2}) {
    EXPECT_LT(found.trials[kind].front().error, 1e-12);
    EXPECT_EQ(least(found.trials[kind]),
              std::min(found.trials[kind][0].error, found.trials[kind][1].error));
  }
}

TEST(Increments, AreTheSmallestStepsAsAccurateAsTheHardestKind) {
  for (const PointModel points : {PointModel::xyz, PointModel::pmba}) {
    const IncrementSearch found = search(test::small_problem({.seed = 5}), 2, points);
    double hardest = 0;
    for (const auto& trials : found.trials) {
      if (!trials.empty()) hardest = std::max(hardest, least(trials));
    }
    EXPECT_EQ(found.attainable, hardest);
    for (std::size_t kind = 0; kind < found.trials.size(); ++kind) {
      if (!has_kind(points, static_cast<ParameterKind>(kind))) continue;
      double smallest = 1;
      for (const IncrementTrial& trial : found.trials[kind]) {
        if (trial.error <= hardest) smallest = std::min(smallest, trial.step);
      }
      EXPECT_EQ(increment(found.found, static_cast<ParameterKind>(kind)), smallest) << kind;
    }
  }
}

// Moved together, a point's anchors and observer would hide one another's effect; differences agree
// with the analytic derivatives for every anchored description all the same.
TEST(Increments, OfAnchoredPoints) {
  for (const PointModel points : {PointModel::idp, PointModel::pba, PointModel::pmba}) {
    const IncrementSearch found = search(test::small_problem({.seed = 3}), 2, points);
    EXPECT_TRUE(found.trials[static_cast<std::size_t>(ParameterKind::point)].empty());
    for (const ParameterKind kind : {ParameterKind::rotation, ParameterKind::translation,
                                     ParameterKind::parallax, ParameterKind::direction}) {
      const auto& trials = found.trials[static_cast<std::size_t>(kind)];
      ASSERT_EQ(trials.size(), 13U);
      EXPECT_LT(least(trials), 1e-5) << static_cast<int>(points) << " " << name(kind);
      EXPECT_GT(trials[2].error, 100 * least(trials));
    }
  }
}

// Lengths follow the world's unit, angles and the lens do not.
TEST(Increments, FollowTheUnitOfLength) {
  Problem problem = test::small_problem({.seed = 7});
  const Increments before = search(problem).found;
  constexpr double unit = 1000;
  for (std::size_t c = 0; c < problem.cameras.size(); c += 9) {
    for (std::size_t k = 3; k < 6; ++k) problem.cameras[c + k] *= unit;
  }
  for (double& x : problem.points) x *= unit;
  const Increments after = search(problem).found;
  EXPECT_EQ(after.rotation, before.rotation);
  EXPECT_NEAR(std::log10(after.translation / before.translation), 3, 1.01);
  EXPECT_NEAR(std::log10(after.point / before.point), 3, 1.01);
}

TEST(Increments, DoNotDependOnThreadsOrMasks) {
  Problem problem = test::small_problem({.seed = 9});
  const IncrementSearch one = search(problem, 1);
  problem.fixed_points.assign(static_cast<std::size_t>(problem.point_count()), 1);
  problem.fixed_camera_parameters.assign(static_cast<std::size_t>(problem.camera_count()), 1);
  const IncrementSearch many = search(problem, 3);
  EXPECT_EQ(one.attainable, many.attainable);
  EXPECT_EQ(one.found.point, many.found.point);
}

TEST(Increments, RefuseWhatHasNoDerivative) {
  Problem problem = test::small_problem({.seed = 9});
  // Where f is 0 the distortion acts on no pixel.
  for (std::size_t c = 0; c < problem.cameras.size(); c += 9) problem.cameras[c + 6] = 0;
  EXPECT_THROW((void)search(problem), InputError);
}

TEST(Increments, NamesAreUnique) {
  std::set<std::string> names;
  for (int k = 0; k < parameter_kinds; ++k) names.insert(name(static_cast<ParameterKind>(k)));
  EXPECT_EQ(names.size(), static_cast<std::size_t>(parameter_kinds));
}

}  // namespace
}  // namespace raybundle
