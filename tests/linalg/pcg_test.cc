#include <raybundle/linalg/pcg.h>
#include <raybundle/linalg/vector.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/QR>

#include <raybundle/linalg/preconditioner.h>
#include <raybundle/tests/support/block_system.h>
#include <raybundle/tests/support/dense_pcg.h>

namespace raybundle::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::BlockSystem;
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

// The five of [Qu18, 3.3.5] on a real reduced system: what each applies, and that it helps.
class Preconditioners : public ::testing::TestWithParam<std::optional<Side>> {
 protected:
  Preconditioners()
      : system_({.seed = 51, .hubs = 12, .leaves = 80, .duplicates = 3, .hub_column_spread = 2}),
        reduced_(make_reduced_system(system_.layout, GetParam(), pool_)) {
    reduced_->prepare(system_.linearization(pool_), system_.D.data());
    SymmetricBlocks matrix(reduced_->pattern(), SymmetricBlocks::Storage::sparse);
    v_.resize(reduced_->size());
    reduced_->assemble(matrix, v_.data());
    A_ = test::dense_of(matrix);
    const std::int64_t at = reduced_->offset(), size = reduced_->size();
    kept_ = system_.H().block(at, at, size, size);
  }

  // The dense matrix whose inverse the preconditioner should apply.
  MatrixXd expected(Preconditioner::Form form, const MatrixXd& from) const {
    if (form == Preconditioner::Form::identity) return MatrixXd::Identity(from.rows(), from.cols());
    if (form == Preconditioner::Form::diagonal) return from.diagonal().asDiagonal();
    MatrixXd blocks = MatrixXd::Zero(from.rows(), from.cols());
    const SymmetricPattern pattern = reduced_->pattern();
    for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
      const std::int64_t o = pattern.offset[index(a)], n = pattern.block_size(a);
      blocks.block(o, o, n, n) = from.block(o, o, n, n);
    }
    return blocks;
  }

  ThreadPool pool_{2};
  BlockSystem system_;
  std::unique_ptr<ReducedSystem> reduced_;
  MatrixXd A_;
  MatrixXd kept_;
  VectorXd v_;
};

TEST_P(Preconditioners, ApplyTheInverseAndPcgConvergesWithEach) {
  using Form = Preconditioner::Form;
  using Blocks = ReducedSystem::Blocks;
  const VectorXd solution = A_.ldlt().solve(v_);
  Preconditioner preconditioner;
  for (const Blocks which : {Blocks::undiminished, Blocks::reduced}) {
    for (const Form form : {Form::identity, Form::diagonal, Form::blocks}) {
      DiagonalBlocks blocks;
      reduced_->diagonal_blocks(which, blocks);
      preconditioner.build(form, blocks);
      const MatrixXd N = expected(form, which == Blocks::reduced ? A_ : kept_);
      VectorXd z = VectorXd::Constant(v_.size(), 1e300);
      preconditioner.apply(v_.data(), z.data(), v_.size(), pool_);
      const VectorXd exact = N.ldlt().solve(v_);
      EXPECT_LE((z - exact).norm(), 1e-9 * exact.norm());

      Pcg pcg(v_.size(), pool_);
      VectorXd x(v_.size());
      const auto result = pcg.solve(
          [&](const double* in, double* out) { reduced_->apply(in, out); },
          [&](const double* in, double* out) { preconditioner.apply(in, out, v_.size(), pool_); },
          v_.data(), {.residual = 1e-12 * v_.norm(), .max_iterations = 20000}, x.data());
      EXPECT_LE((A_ * x - v_).norm(), 1e-10 * v_.norm());
      if (form != Form::identity) {
        const VectorXd s = A_.diagonal().cwiseSqrt();
        EXPECT_LE((x - solution).cwiseProduct(s).norm(), 1e-8 * solution.cwiseProduct(s).norm());
      }
      EXPECT_LT(result.iterations, 20000);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Eliminated, Preconditioners,
                         ::testing::Values(std::optional<Side>(), std::optional<Side>(Side::leaves),
                                           std::optional<Side>(Side::hubs)),
                         [](const auto& test) {
                           if (!test.param) return "Nothing";
                           return *test.param == Side::leaves ? "Leaves" : "Hubs";
                         });

TEST(Preconditioner, IndefiniteAndEmptyEntriesAct) {
  DiagonalBlocks blocks;
  blocks.runs.push_back({3, 2, {4, 0, 0, 0, 0, 0, 0, 0, 1, /**/ 2, 1, 0, 1, 2, 0, 0, 0, nan}});
  ThreadPool pool(1);
  const VectorXd r = VectorXd::Ones(6);
  VectorXd z(6);
  Preconditioner preconditioner;
  preconditioner.build(Preconditioner::Form::diagonal, blocks);
  preconditioner.apply(r.data(), z.data(), 6, pool);
  EXPECT_TRUE(z.isApprox((VectorXd(6) << 0.25, 0, 1, 0.5, 0.5, 0).finished()));
  preconditioner.build(Preconditioner::Form::blocks, blocks);
  preconditioner.apply(r.data(), z.data(), 6, pool);
  EXPECT_TRUE(z.isApprox((VectorXd(6) << 0.25, 0, 1, 0, 0, 0).finished())) << z.transpose();
}

}  // namespace
}  // namespace raybundle::linalg
