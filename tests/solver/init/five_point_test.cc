// Essential matrices of five pairs: the true one is among them, and all are what they claim.

#include <raybundle/solver/init/five_point.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <raybundle/solver/init/epipolar.h>
#include <raybundle/tests/solver/init/two_views.h>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;

double distance(const Matrix3d& A, const Matrix3d& B) {
  return std::min((A - B).norm(), (A + B).norm());
}

TEST(FivePoint, HasTheTrueMatrixAmongItsOwn) {
  int exact = 0;
  constexpr int trials = 200;
  for (std::uint64_t seed = 1; seed <= trials; ++seed) {
    const test::TwoImages images = test::two_images({.seed = seed, .points = 5});
    const Matrix3d truth = essential_matrix(images.pose);
    const EssentialMatrices found = essential_matrices(images.pairs.a, images.pairs.b);
    double best = 2;
    for (const Matrix3d& E : found.all()) best = std::min(best, distance(E, truth));
    exact += best < 1e-6 ? 1 : 0;
    EXPECT_LT(best, 1e-3) << seed;
  }
  EXPECT_GE(exact, trials * 98 / 100);
}

TEST(FivePoint, EveryMatrixFitsThePairsAndIsEssential) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const test::TwoImages images = test::two_images({.seed = seed, .points = 5});
    const EssentialMatrices found = essential_matrices(images.pairs.a, images.pairs.b);
    EXPECT_FALSE(found.all().empty());
    for (const Matrix3d& E : found.all()) {
      const Matrix3d EEt = E * E.transpose();
      EXPECT_NEAR(E.squaredNorm(), 2, 1e-9);
      EXPECT_NEAR(E.determinant(), 0, 1e-6);
      EXPECT_LT((2 * EEt * E - EEt.trace() * E).norm(), 1e-6);
      for (int i = 0; i < 5; ++i) {
        EXPECT_NEAR(images.pairs.b.col(i).dot(E * images.pairs.a.col(i)), 0, 1e-9);
      }
    }
  }
}

TEST(FivePoint, NeverHasAnythingThatIsNotFinite) {
  FiveRays same;
  same.colwise() = Eigen::Vector3d(0, 0, -1);
  const EssentialMatrices found = essential_matrices(same, same);
  for (const Matrix3d& E : found.all()) EXPECT_TRUE(E.allFinite());
}

TEST(Epipolar, OneOfFourPosesIsTheTrueOneAndFacesThePoints) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const test::TwoImages images = test::two_images({.seed = seed, .points = 20});
    std::vector<std::int32_t> all(20);
    std::iota(all.begin(), all.end(), 0);
    const RelativePose pose = facing_pose(essential_matrix(images.pose), images.pairs, all, 1);
    EXPECT_LT(test::angle_between(pose.R, images.pose.R), 1e-9);
    EXPECT_LT((pose.t - images.pose.t).norm(), 1e-9);
    EXPECT_EQ(sides(pose, images.pairs, all, 1).behind, 0);
  }
}

TEST(Epipolar, WhatIsNoNumberFitsNothing) {
  const test::TwoImages images = test::two_images({.points = 3});
  const Matrix3d none = Matrix3d::Constant(std::nan(""));
  EXPECT_FALSE(squared_epipolar_error(none, images.pairs, 0) < 1e300);
  EXPECT_EQ(squared_epipolar_error(Matrix3d::Zero(), images.pairs, 0), 0);
}

// A ray moved out of the epipolar plane by some pixels is that far off, whichever it is.
TEST(Epipolar, ErrorsAreInPixels) {
  test::TwoImages images = test::two_images({.seed = 3, .points = 30});
  const Matrix3d E = essential_matrix(images.pose);
  for (std::int64_t i = 0; i < images.pairs.size(); ++i) {
    EXPECT_LT(squared_epipolar_error(E, images.pairs, i), 1e-12);
    const Eigen::Vector3d b = images.pairs.b.col(i);
    const Eigen::Vector3d normal = (E * images.pairs.a.col(i)).normalized();
    images.pairs.b.col(i) = (b + 3.0 / 1000 * normal).normalized();
    images.pairs.pixels_a[i] = 1e9;  // a is exact: then all is the fault of b
    EXPECT_NEAR(squared_epipolar_error(E, images.pairs, i), 9, 1e-3);
  }
}

}  // namespace
}  // namespace raybundle::init
