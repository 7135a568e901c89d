// The point blocks of parallax points on rays are never singular: the true bound behind
// [Liu18, Theorem 1], derived in docs/parallax.md.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <raybundle/linalg/normal_equations.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/random.h>
#include <raybundle/models/rotation.h>

namespace raybundle {
namespace {

using Eigen::Vector3d;

Vector3d direction(Random& random) {
  for (;;) {
    const Vector3d x(random.normal(), random.normal(), random.normal());
    if (x.norm() > 1e-3) return x.normalized();
  }
}

// Pairs of cameras a unit apart, in any attitude, and points in any direction at 1e-8 to 1e8 of it,
// each seen by one pair. What was observed matters to the derivatives as far only as it tells on
// which side of its cameras a point is.
Problem pairs_of_cameras(int pairs, int points_per_pair, std::uint64_t seed) {
  Random random(seed);
  Problem problem;
  for (int p = 0; p < pairs; ++p) {
    const Vector3d first = 10 * direction(random), second = first + direction(random);
    for (const Vector3d& P : {first, second}) {
      const Vector3d phi = 3 * random.uniform(0, 1) * direction(random);
      const Vector3d t = -(so3::exp(phi) * P);
      problem.cameras.insert(problem.cameras.end(), {phi[0], phi[1], phi[2], t[0], t[1], t[2]});
      problem.cameras.insert(problem.cameras.end(), {1, 0, 0});
    }
    for (int i = 0; i < points_per_pair; ++i) {
      const Vector3d X = first + std::pow(10.0, random.uniform(-8, 8)) * direction(random);
      for (const int camera : {2 * p, 2 * p + 1}) {
        problem.observation_camera.push_back(camera);
        problem.observation_point.push_back(p * points_per_pair + i);
        problem.observations.insert(problem.observations.end(),
                                    {random.uniform(-1, 1), random.uniform(-1, 1)});
      }
      problem.points.insert(problem.points.end(), {X[0], X[1], X[2]});
    }
  }
  return problem;
}

// Of the block of each point, ascending.
std::vector<Vector3d> eigenvalues(const Problem& problem, PointModel points) {
  linalg::ThreadPool pool(2);
  Objective objective(problem,
                      {.lens = Lens::fixed,
                       .points = points,
                       .objective = ObjectiveKind::ray,
                       .ray_weight = RayWeight::unit},
                      pool);
  const State state = objective.state_of(problem);
  linalg::BlockJacobian J(objective.layout());
  linalg::NormalEquations normal(objective.layout());
  objective.linearize(state, J, normal);
  std::vector<Vector3d> result;
  for (std::size_t i = 0; i < normal.C.size(); i += 9) {
    const Eigen::Map<const Eigen::Matrix3d> C(&normal.C[i]);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(C, Eigen::EigenvaluesOnly);
    result.push_back(eigen.eigenvalues());
  }
  return result;
}

double smallest_eigenvalue(const Problem& problem, PointModel points) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Vector3d& each : eigenvalues(problem, points)) smallest = std::min(smallest, each[0]);
  return smallest;
}

TEST(ParallaxBound, HoldsForPmbaAtAnyDepth) {
  const double bound = 0.5 * (3 - std::sqrt(5.0));
  const double found = smallest_eigenvalue(pairs_of_cameras(1000, 100, 1), PointModel::pmba);
  EXPECT_GE(found, 0.38196);
  EXPECT_LE(found, bound + 1e-6) << "[Liu18, Theorem 1] has 1";
}

// A point at infinity across a line of n evenly spaced cameras is seen from the share f of the way
// between its anchors: its block is that of [sum f^2, sum f; sum f, n] and n. So the condition
// number, at least (3 + sqrt 5) / (3 - sqrt 5) for two cameras, grows with them [Liu18, Table 3].
TEST(ParallaxBound, ConditionOfAPointAtInfinityGrowsWithTheCamerasOfALine) {
  for (std::size_t n = 2; n <= 4; ++n) {
    Problem problem;
    problem.points = {0, 0, -1e7};
    Eigen::Matrix2d plane = Eigen::Matrix2d::Zero();
    for (std::size_t k = 0; k < n; ++k) {
      const double f = static_cast<double>(k) / static_cast<double>(n - 1);
      plane += Eigen::Vector2d(f, 1) * Eigen::Vector2d(f, 1).transpose();
      problem.cameras.insert(problem.cameras.end(), {0, 0, 0, -f, 0, 0, 1, 0, 0});
      problem.observation_camera.push_back(static_cast<std::int32_t>(k));
      problem.observation_point.push_back(0);
      problem.observations.insert(problem.observations.end(), {-1e-7 * f, 0});
    }
    const Eigen::Vector3d eigen = eigenvalues(problem, PointModel::pmba).front();
    const Eigen::Vector2d expected =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(plane).eigenvalues();
    EXPECT_NEAR(eigen[0], expected[0], 1e-5) << n << " cameras";
    EXPECT_NEAR(eigen[2], expected[1], 1e-5) << n << " cameras";
    EXPECT_EQ(eigen[2] > 10 * eigen[0], n == 4) << n << " cameras";
  }
}

// It is what tells pmba from the others: these have blocks as close to singular as one likes.
TEST(ParallaxBound, DoesNotHoldForTheOthers) {
  const Problem problem = pairs_of_cameras(100, 100, 2);
  EXPECT_LE(smallest_eigenvalue(problem, PointModel::xyz), 1e-12);
  EXPECT_LE(smallest_eigenvalue(problem, PointModel::idp), 1e-3);
  EXPECT_LE(smallest_eigenvalue(problem, PointModel::pba), 1e-2) << "elevations near a right angle";
}

}  // namespace
}  // namespace raybundle
