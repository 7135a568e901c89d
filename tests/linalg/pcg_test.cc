#include <raybundle/linalg/pcg.h>
#include <raybundle/linalg/vector.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/QR>

#include <raybundle/tests/support/dense_pcg.h>

namespace raybundle::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::random_matrix;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

MatrixXd random_spd(Eigen::Index n, std::uint64_t seed) {
  const MatrixXd B = random_matrix(n + 3, n, seed);
  return B.transpose() * B + 0.05 * MatrixXd::Identity(n, n);
}

using Solved = test::PcgSolution;

Solved solve(const MatrixXd& A, const VectorXd& b, double tolerance, int max_iterations,
             const MatrixXd& N_inverse) {
  return test::solve_dense(A, b, {.residual = tolerance, .max_iterations = max_iterations},
                           N_inverse);
}

Solved solve(const MatrixXd& A, const VectorXd& b, double tolerance, int max_iterations) {
  return solve(A, b, tolerance, max_iterations, MatrixXd::Identity(b.size(), b.size()));
}

TEST(Pcg, ConvergesToTheDenseSolution) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Eigen::Index n = 5 + 7 * static_cast<Eigen::Index>(seed);
    const MatrixXd A = random_spd(n, seed);
    const VectorXd b = random_matrix(n, 1, seed + 100);
    const VectorXd expected = A.ldlt().solve(b);
    const Solved plain = solve(A, b, 1e-12 * b.norm(), 2000);
    EXPECT_LE((plain.x - expected).norm(), 1e-9 * expected.norm());
    const MatrixXd jacobi = A.diagonal().cwiseInverse().asDiagonal();
    const Solved scaled = solve(A, b, 1e-12 * b.norm(), 2000, jacobi);
    EXPECT_LE((scaled.x - expected).norm(), 1e-9 * expected.norm());
  }
}

TEST(Pcg, AnExactPreconditionerNeedsOneIteration) {
  const MatrixXd A = random_spd(30, 4);
  const VectorXd b = random_matrix(30, 1, 5);
  const Solved solved = solve(A, b, 1e-9 * b.norm(), 100, A.inverse());
  EXPECT_EQ(solved.result.iterations, 1);
}

TEST(Pcg, NeedsAsManyIterationsAsThereAreEigenvalues) {
  VectorXd d(60);
  for (Eigen::Index i = 0; i < 60; ++i) d[i] = 1.0 + static_cast<double>(i % 4);
  const MatrixXd Q = random_spd(60, 6).householderQr().householderQ();
  const MatrixXd A = Q * d.asDiagonal() * Q.transpose();
  EXPECT_EQ(solve(A, random_matrix(60, 1, 7), 1e-10, 100).result.iterations, 4);
}

// Stops at the first iterate with |A x - b| <= tolerance, and says the truth about it.
TEST(Pcg, ToleranceIsTheResidualNorm) {
  const MatrixXd A = random_spd(40, 8);
  const VectorXd b = random_matrix(40, 1, 9);
  for (const double tolerance : {1.0, 1e-1, 1e-3, 1e-6}) {
    const Solved solved = solve(A, b, tolerance, 1000);
    const double residual = (A * solved.x - b).norm();
    EXPECT_LE(residual, tolerance * (1 + 1e-9));
    EXPECT_NEAR(solved.result.residual_norm, residual, 1e-9 * b.norm());
    ASSERT_GT(solved.result.iterations, 0);
    const Solved before = solve(A, b, tolerance, solved.result.iterations - 1);
    EXPECT_EQ(before.result.iterations, solved.result.iterations - 1);
    EXPECT_GT((A * before.x - b).norm(), tolerance);
  }
}

TEST(Pcg, AToleranceAboveTheRightSideNeedsNoIteration) {
  const VectorXd b = random_matrix(10, 1, 2);
  const Solved solved = solve(random_spd(10, 1), b, b.norm() * 1.0001, 100);
  EXPECT_EQ(solved.result.iterations, 0);
  EXPECT_TRUE(solved.x.isZero(0));
  EXPECT_NEAR(solved.result.residual_norm, b.norm(), 1e-14);
}

TEST(Pcg, ZeroRightSide) {
  const Solved solved = solve(random_spd(10, 1), VectorXd::Zero(10), 0.0, 100);
  EXPECT_EQ(solved.result.iterations, 0);
  EXPECT_TRUE(solved.x.isZero(0));
}

TEST(Pcg, KeepsToTheIterationCap) {
  const MatrixXd A = random_spd(50, 3);
  const VectorXd b = random_matrix(50, 1, 4);
  for (const int cap : {0, 1, 7}) EXPECT_EQ(solve(A, b, 0.0, cap).result.iterations, cap);
}

// Every iterate lowers the quadratic: what a truncated Newton method lives on.
TEST(Pcg, TheModelFallsWithEveryIteration) {
  const MatrixXd A = random_spd(40, 10);
  const VectorXd b = random_matrix(40, 1, 11);
  const MatrixXd jacobi = A.diagonal().cwiseInverse().asDiagonal();
  double previous = 0;
  for (int k = 1; k <= 20; ++k) {
    const VectorXd x = solve(A, b, 0.0, k, jacobi).x;
    const double model = 0.5 * x.dot(A * x) - b.dot(x);
    EXPECT_LT(model, previous);
    previous = model;
  }
}

TEST(Pcg, SemidefiniteAndConsistentSystemsAreSolved) {
  const MatrixXd B = random_matrix(20, 30, 12);  // rank 20 of 30
  const MatrixXd A = B.transpose() * B;
  const VectorXd b = A * random_matrix(30, 1, 13);
  const Solved solved = solve(A, b, 1e-10 * b.norm(), 1000);
  EXPECT_LE((A * solved.x - b).norm(), 1e-8 * b.norm());
}

TEST(Pcg, DirectionsWithoutCurvatureEndTheSolve) {
  MatrixXd A = MatrixXd::Identity(4, 4);
  A(3, 3) = 0;
  VectorXd b = VectorXd::Zero(4);
  b[3] = 1;  // nothing can be done about it
  const Solved none = solve(A, b, 1e-10, 100);
  EXPECT_EQ(none.result.iterations, 0);
  EXPECT_TRUE(none.x.isZero(0));
  A(3, 3) = -1;
  EXPECT_TRUE(solve(A, b, 1e-10, 100).x.isZero(0));
  const MatrixXd B = random_matrix(20, 30, 14);
  const Solved rounding = solve(B.transpose() * B, random_matrix(30, 1, 15), 0.0, 10000);
  EXPECT_TRUE(rounding.x.allFinite());
}

TEST(Pcg, NonFiniteNumbersEndTheSolve) {
  MatrixXd A = random_spd(5, 1);
  VectorXd b = VectorXd::Ones(5);
  b[2] = nan;
  EXPECT_EQ(solve(A, b, 1e-10, 100).result.iterations, 0);
  A(1, 1) = nan;
  EXPECT_LE(solve(A, VectorXd::Ones(5), 1e-10, 100).result.iterations, 1);
}

TEST(Dot, SameBitsForAnyNumberOfThreads) {
  const VectorXd u = random_matrix(100000, 1, 1), v = random_matrix(100000, 1, 2);
  std::vector<double> sums;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    sums.push_back(dot(u.data(), v.data(), u.size(), pool));
  }
  EXPECT_EQ(sums[0], sums[1]);
  EXPECT_EQ(sums[0], sums[2]);
  EXPECT_NEAR(sums[0], u.dot(v), 1e-9);
}

}  // namespace
}  // namespace raybundle::linalg
