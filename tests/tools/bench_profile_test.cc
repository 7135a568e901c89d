// Performance profiles and times to an accuracy, against examples computed by hand.

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/tools/bench_profile.h>

namespace raybundle::tools {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

TEST(Profile, TargetLiesBetweenStartAndBest) {
  EXPECT_DOUBLE_EQ(target_cost(110, 10, 0.1), 20);
  EXPECT_DOUBLE_EQ(target_cost(110, 10, 0), 10);
  EXPECT_DOUBLE_EQ(target_cost(110, 10, 1), 110);
}

TEST(Profile, TimeIsThatOfTheFirstStateThatIsGoodEnough) {
  const std::vector<CostAt> trace = {{0.5, 100}, {1, NAN}, {2, 20}, {3, 25}, {4, 10}};
  EXPECT_EQ(seconds_to(trace, 100), 0.5);
  EXPECT_EQ(seconds_to(trace, 20), 2);
  EXPECT_EQ(seconds_to(trace, 19), 4);
  EXPECT_EQ(seconds_to(trace, 9), never);
  EXPECT_EQ(seconds_to({}, 1), never);
}

TEST(Profile, MedianCountsWhatWasNeverReached) {
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 2, 3}), 2.5);
  EXPECT_EQ(median({1, never, 2}), 2);
  EXPECT_EQ(median({never, 1, never}), never);
  EXPECT_EQ(median({1, NAN, NAN}), never);
  EXPECT_TRUE(std::isnan(median({})));
}

// Four problems, three solvers. Best: 1 (A), 2 (B), 3 (A and B), none.
TEST(Profile, SharesByHand) {
  const std::vector<std::vector<double>> seconds = {
      {1, 4, never}, {6, 2, 4}, {3, 3, 30}, {never, never, never}};
  const std::vector<Profile> all = profiles(seconds);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].ratio, (std::vector<double>{1, 3}));  // 1, 3, 1
  EXPECT_EQ(all[0].share, (std::vector<double>{0.5, 0.75}));
  EXPECT_EQ(all[1].ratio, (std::vector<double>{1, 4}));  // 4, 1, 1
  EXPECT_EQ(all[1].share, (std::vector<double>{0.5, 0.75}));
  EXPECT_EQ(all[2].ratio, (std::vector<double>{1, 2, 10}));  // never first
  EXPECT_EQ(all[2].share, (std::vector<double>{0, 0.25, 0.5}));
  EXPECT_EQ(share_at(all[2], 1), 0);
  EXPECT_EQ(share_at(all[2], 1.99), 0);
  EXPECT_EQ(share_at(all[2], 2), 0.25);
  EXPECT_EQ(share_at(all[2], never), 0.5);
  EXPECT_EQ(share_at(all[2], 0.5), 0);
}

TEST(Profile, ATimeOfZeroIsNoDivision) {
  const std::vector<Profile> all = profiles({{0, 0}, {0, 1}});
  EXPECT_EQ(share_at(all[0], 1), 1);
  EXPECT_EQ(share_at(all[1], 1), 0.5);
  EXPECT_EQ(share_at(all[1], never), 1);
}

TEST(Profile, OfNothing) { EXPECT_TRUE(profiles({}).empty()); }

}  // namespace
}  // namespace raybundle::tools
