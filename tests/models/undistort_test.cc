// Problems seen by other lenses: the rays stay, and so does what they say of the points.

#include <raybundle/models/rays.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/error.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

TEST(Undistorted, KeepsTheRays) {
  Problem problem = test::small_problem({.seed = 3});
  problem.aspect = 1.25;
  ASSERT_NE(problem.cameras[7], 0);
  const Problem plain = undistorted(problem);
  EXPECT_LE(largest_difference(observed_rays(plain), observed_rays(problem)), 1e-14);
  for (std::size_t c = 0; c < plain.cameras.size(); c += 9) {
    EXPECT_EQ(plain.cameras[c + 6], problem.cameras[c + 6]);
    EXPECT_EQ(plain.cameras[c + 7], 0);
    EXPECT_EQ(plain.cameras[c + 8], 0);
  }
  EXPECT_NE(plain.observations, problem.observations);
  EXPECT_EQ(undistorted(plain).observations, plain.observations) << "to the last digit";
}

TEST(Undistorted, IsExactWhereTheProblemIs) {
  const Problem problem = test::small_problem({.seed = 3, .pixel_noise = 0, .parameter_noise = 0});
  EXPECT_LE(reprojection_statistics(undistorted(problem)).largest, 1e-9);
  EXPECT_LE(reprojection_statistics(with_one_focal_length(undistorted(problem))).largest, 1e-9);
}

TEST(Undistorted, RefusesWhatNoLensMakes) {
  Problem problem = test::small_problem({.seed = 3});
  problem.cameras[7] = -0.5;  // folds back at a radius of 0.82, where a pixel has 0.54 f
  problem.cameras[8] = 0;
  problem.observation_camera[0] = 0;
  problem.observations[0] = 0.6 * problem.cameras[6];
  try {
    (void)undistorted(problem);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("observation 0 at"), std::string::npos)
        << error.what();
  }
}

// A lens that grows nearly for ever, beyond where it folds back.
TEST(Undistorted, ALensThatFoldsBackFarOutEndsThere) {
  const double lens[] = {1, 0.1, -1e-20};
  const double inside[] = {1e20, 0}, outside[] = {1e30, 0};
  EXPECT_TRUE(undistort(lens, inside));
  EXPECT_FALSE(undistort(lens, outside));
}

TEST(OneFocalLength, IsTheMedianAndKeepsTheRays) {
  Problem problem = test::small_problem({.seed = 3, .cameras = 5});
  const double f[] = {400, 900, 500, 700, 100};
  for (std::size_t c = 0; c < 5; ++c) problem.cameras[9 * c + 6] = f[c];
  const Problem one = with_one_focal_length(problem);
  for (std::size_t c = 0; c < 5; ++c) EXPECT_EQ(one.cameras[9 * c + 6], 500);
  EXPECT_LE(largest_difference(apparent_rays(one), apparent_rays(problem)), 1e-12);
  problem.cameras[9 * static_cast<std::size_t>(problem.observation_camera[0]) + 6] = 0;
  EXPECT_THROW((void)with_one_focal_length(problem), InputError);
}

}  // namespace
}  // namespace raybundle
