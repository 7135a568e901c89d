// Conjugate gradients within a trust region against the exact solution of the region's problem.

#include <raybundle/linalg/pcg.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <raybundle/tests/support/dense_pcg.h>

namespace raybundle::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::random_matrix;

// The quadratic of a random region problem.
struct Region {
  explicit Region(std::uint64_t seed, Eigen::Index n = 25)
      : A(MatrixXd(n, n)), b(random_matrix(n, 1, seed + 50)) {
    const MatrixXd B = random_matrix(n + 2, n, seed);
    A = B.transpose() * B + 1e-3 * MatrixXd::Identity(n, n);
  }

  double decrease(const VectorXd& x) const { return b.dot(x) - 0.5 * x.dot(A * x); }

  // The minimiser within the region: (A + lambda I) x = b with |x| = radius, by bisection.
  VectorXd exact(double radius) const {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
    const VectorXd c = eigen.eigenvectors().transpose() * b;
    const auto at = [&](double lambda) -> VectorXd {
      return eigen.eigenvectors() * (c.array() / (eigen.eigenvalues().array() + lambda)).matrix();
    };
    const double least = std::max(0.0, -eigen.eigenvalues()[0]);
    if (least == 0 && at(0).norm() <= radius) return at(0);
    double low = least, high = least + b.norm() / radius;
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (low + high);
      (at(middle).norm() > radius ? low : high) = middle;
    }
    return at(high);
  }

  MatrixXd A;
  VectorXd b;
};

using Solved = test::PcgSolution;

Solved solve(const Region& region, const Pcg::Stop& stop, const MatrixXd& N_inverse) {
  return test::solve_dense(region.A, region.b, stop, N_inverse);
}
Solved solve(const Region& region, const Pcg::Stop& stop) {
  return test::solve_dense(region.A, region.b, stop);
}

// A convex quadratic: at least half the best decrease within the region [Yuan00, Thm. 2.3].
TEST(Steihaug, DecreasesAtLeastHalfOfTheBest) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Region region(seed);
    const double newton = region.exact(1e6).norm();
    for (const double share : {1e-3, 0.03, 0.2, 0.6, 0.95}) {
      const double radius = share * newton;
      const Solved solved =
          solve(region, {.residual = 1e-10, .max_iterations = 500, .radius = radius});
      EXPECT_EQ(solved.result.end, Pcg::End::boundary);
      EXPECT_NEAR(solved.x.norm(), radius, 1e-12 * radius);
      const double best = region.decrease(region.exact(radius));
      EXPECT_GE(region.decrease(solved.x), 0.5 * best);
      EXPECT_LE(region.decrease(solved.x), best * (1 + 1e-9));
    }
  }
}

TEST(Steihaug, ASmallRegionTakesTheSteepestDescent) {
  const Region region(3);
  const double radius = 1e-6;
  const Solved solved = solve(region, {.residual = 1e-10, .radius = radius});
  EXPECT_EQ(solved.result.iterations, 1);
  EXPECT_LE((solved.x - radius * region.b.normalized()).norm(), 1e-12 * radius);
}

TEST(Steihaug, ARegionThatIsNotReachedChangesNothing) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Region region(seed);
    const double newton = region.exact(1e6).norm();
    const Pcg::Stop free = {.residual = 1e-8, .max_iterations = 500};
    Pcg::Stop wide = free;
    wide.radius = 1.01 * newton;
    const Solved without = solve(region, free), with = solve(region, wide);
    EXPECT_EQ(with.result.end, Pcg::End::tolerance);
    EXPECT_EQ(with.result.iterations, without.result.iterations);
    EXPECT_TRUE((with.x.array() == without.x.array()).all());
  }
}

// With a preconditioner too: from the inside to the first crossing, always downhill.
TEST(Steihaug, APreconditionerKeepsToTheRegionAndDescends) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Region region(seed);
    const MatrixXd jacobi = region.A.diagonal().cwiseInverse().asDiagonal();
    const double newton = region.exact(1e6).norm();
    double previous = 0;
    for (const double share : {0.01, 0.1, 0.5, 0.9}) {
      const double radius = share * newton;
      const Solved solved =
          solve(region, {.residual = 1e-10, .max_iterations = 500, .radius = radius}, jacobi);
      EXPECT_LE(solved.x.norm(), radius * (1 + 1e-12));
      EXPECT_GT(region.decrease(solved.x), previous) << "a larger region allows more";
      previous = region.decrease(solved.x);
    }
  }
}

TEST(Steihaug, NegativeCurvatureLeadsToTheBoundary) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Region region(seed);
    region.A -= 5 * MatrixXd::Identity(25, 25);
    const Solved solved = solve(region, {.residual = 1e-10, .max_iterations = 500, .radius = 2});
    EXPECT_EQ(solved.result.end, Pcg::End::boundary);
    EXPECT_NEAR(solved.x.norm(), 2, 1e-12);
    const VectorXd steepest = 2 * region.b.normalized();
    EXPECT_GE(region.decrease(solved.x), 0.999 * std::max(0.0, region.decrease(steepest)));
  }
  Region flat(1);
  flat.A.setZero();  // no curvature at all: the first direction, all the way
  const Solved solved = solve(flat, {.residual = 1e-10, .radius = 3});
  EXPECT_LE((solved.x - 3 * flat.b.normalized()).norm(), 1e-12);
  EXPECT_EQ(solve(flat, {.residual = 1e-10}).result.end, Pcg::End::breakdown) << "and no region";
}

TEST(Steihaug, NumbersThatAreNotFiniteBreakDown) {
  Region region(1);
  region.A(3, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(solve(region, {.residual = 1e-10, .radius = 1}).result.end, Pcg::End::breakdown);
  region = Region(1);
  region.b[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(solve(region, {.residual = 1e-10, .radius = 1}).result.end, Pcg::End::breakdown);
}

// Ends at the first iteration j with j (Q_j - Q_{j-1}) / Q_j <= t  [NashSofer90].
TEST(Steihaug, TheDecreaseOfTheQuadraticEndsTheIterations) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Region region(seed);
    for (const double t : {0.5, 0.1, 0.01}) {
      const int end = solve(region, {.model_decrease = t, .max_iterations = 200}).result.iterations;
      const auto share = [&](int j) {
        const double now = region.decrease(solve(region, {.max_iterations = j}).x);
        const double before = region.decrease(solve(region, {.max_iterations = j - 1}).x);
        return j * (now - before) / now;
      };
      ASSERT_GT(end, 0);
      EXPECT_LE(share(end), t * (1 + 1e-6));
      for (int j = 1; j < end; ++j) EXPECT_GT(share(j), t * (1 - 1e-6)) << j << " of " << end;
    }
  }
}

}  // namespace
}  // namespace raybundle::linalg
