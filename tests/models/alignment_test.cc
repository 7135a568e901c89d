#include <raybundle/models/alignment.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <raybundle/models/error.h>
#include <raybundle/models/rotation.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/support/random_problem.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::small_problem;

Vector3d random_vector(std::mt19937_64& random) {
  const double x = test::uniform(random), y = test::uniform(random), z = test::uniform(random);
  return {x, y, z};
}

std::vector<double> random_points(std::uint64_t seed, int count) {
  std::mt19937_64 random(seed);
  std::vector<double> points;
  for (int i = 0; i < 3 * count; ++i) points.push_back(5 * test::uniform(random));
  return points;
}

Similarity random_similarity(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Similarity S;
  S.scale = std::exp(2 * test::uniform(random));
  S.R = so3::exp(Vector3d(3 * random_vector(random)));
  S.t = 10 * random_vector(random);
  return S;
}

std::vector<double> moved(const Similarity& S, const std::vector<double>& points) {
  std::vector<double> result;
  for (std::size_t i = 0; i < points.size(); i += 3) {
    const Vector3d y = S(Vector3d(points[i], points[i + 1], points[i + 2]));
    result.insert(result.end(), y.data(), y.data() + 3);
  }
  return result;
}

double rmse(const Similarity& S, const std::vector<double>& a, const std::vector<double>& b) {
  return root_mean_square(distances(S, a, b));
}

void expect_rotation(const Matrix3d& R) {
  EXPECT_TRUE((R.transpose() * R).isIdentity(1e-14));
  EXPECT_NEAR(R.determinant(), 1, 1e-14);
}

TEST(Alignment, RecoversASimilarity) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Similarity truth = random_similarity(seed);
    const std::vector<double> a = random_points(seed, seed % 2 == 0 ? 4 : 100);
    const std::vector<double> b = moved(truth, a);
    const Similarity S = align(a, b);
    EXPECT_NEAR(S.scale, truth.scale, 1e-12 * truth.scale);
    EXPECT_TRUE(S.R.isApprox(truth.R, 1e-12));
    EXPECT_LE((S.t - truth.t).norm(), 1e-12 * (truth.t.norm() + 5 * truth.scale));
    EXPECT_LE(rmse(S, a, b), 1e-13 * (truth.t.norm() + 10 * truth.scale));
  }
}

// Nothing near the answer is better: the gradient vanishes along all seven directions, and the cost
// rises.
TEST(Alignment, IsTheLeastSquaresOptimum) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::vector<double> a = random_points(seed, 30);
    std::vector<double> b = moved(random_similarity(seed), a);
    std::mt19937_64 random(seed);
    for (double& x : b) x += test::uniform(random);
    const Similarity best = align(a, b);
    expect_rotation(best.R);
    for (int trial = 0; trial < 50; ++trial) {
      Similarity other = best;
      other.scale *= 1 + 1e-3 * test::uniform(random);
      other.R = best.R * so3::exp(Vector3d(1e-3 * random_vector(random)));
      other.t += 1e-3 * random_vector(random);
      EXPECT_GE(rmse(other, a, b), rmse(best, a, b));
    }
  }
}

// The error is of the shape: it does not depend on where, how turned and how large the estimate is.
TEST(Alignment, ErrorDoesNotDependOnTheEstimatesFrame) {
  const std::vector<double> b = random_points(1, 40);
  std::vector<double> a = b;
  std::mt19937_64 random(2);
  for (double& x : a) x += 0.1 * test::uniform(random);
  const double error = rmse(align(a, b), a, b);
  EXPECT_GT(error, 0.01);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::vector<double> elsewhere = moved(random_similarity(seed), a);
    EXPECT_NEAR(rmse(align(elsewhere, b), elsewhere, b), error, 1e-12);
  }
}

TEST(Alignment, NeverMirrors) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::vector<double> a = random_points(seed, 10);
    std::vector<double> b = a;
    for (std::size_t i = 2; i < b.size(); i += 3) b[i] = -b[i];
    const Similarity S = align(a, b);
    expect_rotation(S.R);
    EXPECT_GT(S.scale, 0);
    EXPECT_GT(rmse(S, a, b), 0.1);
  }
}

TEST(Alignment, PlanarAndCollinearSetsFit) {
  for (const int dimensions : {1, 2}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      std::vector<double> a = random_points(seed, 12);
      for (std::size_t i = 0; i < a.size(); i += 3) {
        if (dimensions < 2) a[i + 1] = 0.5 * a[i] + 1;
        a[i + 2] = 2 - a[i];
      }
      const Similarity truth = random_similarity(seed);
      const std::vector<double> b = moved(truth, a);
      const Similarity S = align(a, b);
      expect_rotation(S.R);
      EXPECT_NEAR(S.scale, truth.scale, 1e-12 * truth.scale);
      EXPECT_LE(rmse(S, a, b), 1e-12 * (1 + truth.scale));
    }
  }
}

TEST(Alignment, PlacesWithoutAShapeAreMovedOnly) {
  const std::vector<double> spread = random_points(1, 4);
  std::vector<double> place;
  for (int i = 0; i < 4; ++i) place.insert(place.end(), {0.1, 0.2, 1e6 + 0.3});
  for (const auto& [a, b] :
       {std::pair(place, spread), std::pair(spread, place), std::pair(place, place),
        std::pair(random_points(2, 1), random_points(3, 1))}) {
    const Similarity S = align(a, b);
    EXPECT_EQ(S.scale, 1);
    EXPECT_TRUE(S.R.isIdentity(0));
    EXPECT_TRUE(S.t.allFinite());
    EXPECT_TRUE(std::isfinite(rmse(S, a, b)));
  }
  const std::vector<double> one = random_points(2, 1);
  EXPECT_LE(rmse(align(one, random_points(3, 1)), one, random_points(3, 1)), 1e-15 * 10);
  EXPECT_EQ(align({}, {}).scale, 1);
  EXPECT_EQ(rmse({}, {}, {}), 0);
  EXPECT_EQ(upper_median({}), 0);
  // A square and the same square with neighbours exchanged: nothing in common along either side.
  const std::vector<double> square = {1, 1, 0, -1, 1, 0, -1, -1, 0, 1, -1, 0};
  const std::vector<double> unrelated = {1, 0, 0, -1, 0, 0, 1, 0, 0, -1, 0, 0};
  EXPECT_TRUE(std::isfinite(rmse(align(square, unrelated), square, unrelated)));
}

TEST(Alignment, HugeAndTinyCoordinates) {
  for (const double size : {1e-200, 1e200}) {
    std::vector<double> a = random_points(1, 10);
    const std::vector<double> b = moved(random_similarity(1), a);
    for (double& x : a) x *= size;
    const Similarity S = align(a, b);
    expect_rotation(S.R);
    EXPECT_LE(rmse(S, a, b), 1e-12);
  }
}

TEST(Alignment, RefusesUnequalSizes) {
  EXPECT_THROW(align(random_points(1, 3), random_points(1, 4)), InputError);
  EXPECT_THROW(align({1, 2}, {1, 2}), InputError);
  EXPECT_THROW(distances({}, random_points(1, 3), random_points(1, 4)), InputError);
}

/// The world of `problem` seen in another frame, X' = S X: every residual stays.
Problem in_frame(const Similarity& S, Problem problem) {
  problem.points = moved(S, problem.points);
  for (std::size_t j = 0; j < problem.cameras.size(); j += 9) {
    Eigen::Map<Vector3d> phi(&problem.cameras[j]);
    Eigen::Map<Vector3d> t(&problem.cameras[j + 3]);
    const Matrix3d R = so3::exp(Vector3d(phi)) * S.R.transpose();
    t = S.scale * Vector3d(t) - R * S.t;
    phi = so3::log(R);
  }
  return problem;
}

TEST(Truth, AnotherFrameIsNoError) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Problem truth = small_problem({.seed = seed, .cameras = 6});
    const Problem problem = in_frame(random_similarity(seed), truth);
    const TruthErrors errors = compare_with_truth(problem, truth);
    EXPECT_EQ(errors.cameras, 6);
    EXPECT_EQ(errors.points, 20);
    EXPECT_LE(errors.camera_rmse, 1e-12);
    EXPECT_LE(errors.point_rmse, 1e-12);
    EXPECT_LE(errors.rotation_mean, 1e-6);
    EXPECT_NEAR(errors.camera_alignment.scale * random_similarity(seed).scale, 1, 1e-12);
    EXPECT_NEAR(errors.point_alignment.scale * random_similarity(seed).scale, 1, 1e-12);
  }
}

TEST(Truth, CamerasAndPointsAreAlignedSeparately) {
  const Problem truth = small_problem({.seed = 3, .cameras = 8});
  Problem problem = truth;
  problem.points = moved(random_similarity(4), truth.points);  // the cameras stay
  const TruthErrors errors = compare_with_truth(problem, truth);
  EXPECT_LE(errors.camera_rmse, 1e-12);
  EXPECT_LE(errors.point_rmse, 1e-12);
}

TEST(Truth, OfAKnownError) {
  const Problem truth = small_problem({.seed = 5, .cameras = 4, .points = 300});
  Problem problem = truth;
  problem.points[3 * 7] += 0.3;  // hardly changes the alignment of so many
  const double camera_turn = 0.02;
  Eigen::Map<Vector3d> phi(problem.cameras.data());
  phi = so3::compose(phi, camera_turn * Vector3d(0, 0, 1));
  const TruthErrors errors = compare_with_truth(problem, truth);
  EXPECT_NEAR(errors.point_errors[7], 0.3, 0.01);
  EXPECT_LE(errors.point_median, 0.03);
  EXPECT_NEAR(errors.point_rmse, 0.3 / std::sqrt(300), 1e-3);
  // One of four is turned; the best turn of the world is a quarter of that: 3/4 + 3 * 1/4 of it.
  const double degrees = camera_turn * 180 / 3.14159265358979323846;
  EXPECT_NEAR(errors.rotation_mean, degrees * (0.75 + 3 * 0.25) / 4, 1e-3 * degrees);
}

TEST(Truth, RotationsDoNotNeedCentresOffALine) {
  Problem truth = small_problem({.seed = 6, .cameras = 5});
  for (std::size_t j = 0; j < 5; ++j) {  // centres (j, 0, 0)
    const Matrix3d R = so3::exp(Vector3d(Eigen::Map<const Vector3d>(&truth.cameras[9 * j])));
    Eigen::Map<Vector3d>(&truth.cameras[9 * j + 3]) = -static_cast<double>(j) * R.col(0);
  }
  const TruthErrors errors = compare_with_truth(in_frame(random_similarity(8), truth), truth);
  EXPECT_LE(errors.camera_rmse, 1e-12);
  EXPECT_LE(errors.rotation_mean, 1e-6);
}

// One point far off takes the points' alignment and RMSE with it; the median tells the rest.
TEST(Truth, MedianStandsAFarPoint) {
  const Problem truth = small_problem({.seed = 9, .cameras = 6, .points = 101});
  Problem problem = truth;
  for (std::size_t i = 0; i < 303; i += 3) problem.points[i] += 0.01;
  problem.points[6] += 1e6;
  const TruthErrors errors = compare_with_truth(problem, truth);
  EXPECT_GT(errors.point_rmse, 0.1);
  EXPECT_NEAR(errors.point_median, 0.01, 1e-9);
  EXPECT_LT(errors.point_alignment.scale, 1e-3);  // all shrunk to nothing beside that one
  EXPECT_GT(errors.point_median_own, 0.1);
  // The error of each is by the cameras too: the far one is told from the others.
  EXPECT_NEAR(errors.point_errors[0], 0.01, 1e-9);
  EXPECT_NEAR(errors.point_errors[2], 1e6, 1);
  EXPECT_NEAR(errors.point_rmse_by_cameras, 1e6 / std::sqrt(101), 1);
}

TEST(Truth, WhatNobodyObservesIsLeftOut) {
  const Problem truth = small_problem(
      {.seed = 7, .cameras = 6, .points = 25, .unobserved_cameras = 1, .unobserved_points = 2});
  Problem problem = truth;
  for (std::size_t k = 3; k < 6; ++k) problem.cameras[45 + k] += 1e6;
  for (std::size_t k = 0; k < 6; ++k) problem.points[69 + k] += 1e6;
  const TruthErrors errors = compare_with_truth(problem, truth);
  EXPECT_EQ(errors.cameras, 5);
  EXPECT_EQ(errors.points, 23);
  EXPECT_LE(errors.camera_rmse, 1e-12);
  EXPECT_LE(errors.point_rmse, 1e-12);
  EXPECT_TRUE(std::isnan(errors.camera_errors[5]));
  EXPECT_TRUE(std::isnan(errors.point_errors[23]));
  EXPECT_FALSE(std::isnan(errors.point_errors[22]));
}

TEST(Truth, OfCamerasAlone) {
  Problem truth = small_problem({.seed = 8, .cameras = 6});
  Problem problem = truth;
  problem.cameras[3] += 0.2;
  const TruthErrors whole = compare_with_truth(problem, truth);
  truth.points.clear();
  const TruthErrors errors = compare_with_truth(problem, truth);
  EXPECT_GT(errors.camera_rmse, 0);
  EXPECT_EQ(errors.camera_rmse, whole.camera_rmse);
  EXPECT_EQ(errors.rotation_mean, whole.rotation_mean);
  EXPECT_EQ(errors.points, 0);
  EXPECT_TRUE(errors.point_errors.empty());
}

TEST(Truth, MustHaveAsManyCamerasAndPoints) {
  const Problem problem = small_problem({.seed = 1, .cameras = 4, .points = 20});
  EXPECT_THROW(compare_with_truth(problem, small_problem({.cameras = 5, .points = 20})),
               InputError);
  EXPECT_THROW(compare_with_truth(problem, small_problem({.cameras = 4, .points = 21})),
               InputError);
}

}  // namespace
}  // namespace raybundle
