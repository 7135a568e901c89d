// The point blocks of parallax points on rays are never singular: the true bound behind
// [Liu18, Theorem 1], derived in docs/parallax.md.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <raybundle/linalg/normal_equations.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/rotation.h>
#include <raybundle/models/scenes/random.h>

namespace raybundle {
namespace {

using Eigen::Vector3d;
using scenes::Random;

Vector3d direction(Random& random) {
  for (;;) {
    const Vector3d x(random.normal(), random.normal(), random.normal());
    if (x.norm() > 1e-3) return x.normalized();
  }
}

// Pairs of cameras a unit apart, in any attitude, and points in any direction at 1e-8 to 1e8 of it,
// each seen by one pair. What was observed does not matter to the derivatives.
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

double smallest_eigenvalue(const Problem& problem, PointModel points) {
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
  Eigen::VectorXd residual(objective.layout().residuals());
  objective.linearize(state, residual.data(), J);
  normal.form(J, residual.data(), pool);
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < normal.C.size(); i += 9) {
    const Eigen::Map<const Eigen::Matrix3d> C(&normal.C[i]);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(C, Eigen::EigenvaluesOnly);
    smallest = std::min(smallest, eigen.eigenvalues()[0]);
  }
  return smallest;
}

TEST(ParallaxBound, HoldsForPmbaAtAnyDepth) {
  const double bound = 0.5 * (3 - std::sqrt(5.0));
  const double found = smallest_eigenvalue(pairs_of_cameras(1000, 100, 1), PointModel::pmba);
  EXPECT_GE(found, 0.38196);
  EXPECT_LE(found, bound + 1e-6) << "[Liu18, Theorem 1] has 1";
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
