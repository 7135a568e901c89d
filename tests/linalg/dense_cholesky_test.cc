#include <raybundle/linalg/dense_cholesky.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <raybundle/linalg/cpu.h>
#include <raybundle/linalg/parallel.h>

namespace raybundle::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

/// The sets this machine can run, the baseline first.
std::vector<InstructionSet> runnable_sets() {
  std::vector<InstructionSet> sets;
  for (const auto set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
    if (set <= detected_instruction_set()) sets.push_back(set);
  }
  return sets;
}

MatrixXd random_matrix(std::int64_t rows, std::int64_t columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

MatrixXd random_spd(std::int64_t n, unsigned seed) {
  const MatrixXd B = random_matrix(n, n + 5, seed);
  return B * B.transpose() + 0.1 * MatrixXd::Identity(n, n);
}

/// Positive definite with row and column k scaled by 10^uniform(-8, 8).
MatrixXd badly_scaled(std::int64_t n, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> exponent(-8.0, 8.0);
  const VectorXd scale =
      VectorXd::NullaryExpr(n, [&] { return std::pow(10.0, exponent(generator)); });
  return scale.asDiagonal() * random_spd(n, seed) * scale.asDiagonal();
}

bool factor_in_place(MatrixXd& A, int threads, InstructionSet set = instruction_set()) {
  ThreadPool pool(threads);
  return DenseCholesky(A.rows(), set).factor(A.data(), A.rows(), pool);
}

MatrixXd lower(const MatrixXd& A) { return A.triangularView<Eigen::Lower>(); }

/// The largest |A - L L^T|_ij / sqrt(a_ii a_jj) over the lower triangle, in long double.
double scaled_residual(const MatrixXd& A, const MatrixXd& L) {
  using Long = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  const Eigen::Matrix<long double, Eigen::Dynamic, 1> root =
      A.diagonal().cast<long double>().cwiseSqrt().cwiseInverse();
  const Long L_scaled = root.asDiagonal() * lower(L).cast<long double>();
  Long R = root.asDiagonal() * A.cast<long double>() * root.asDiagonal();
  R.triangularView<Eigen::Lower>() -= L_scaled * L_scaled.transpose();
  return static_cast<double>(lower(R.cast<double>()).cwiseAbs().maxCoeff());
}

std::vector<std::int64_t> orders() {
  std::vector<std::int64_t> list;
  for (std::int64_t n = 1; n <= 70; ++n) list.push_back(n);
  for (const std::int64_t n : {97, 128, 144, 189, 200}) list.push_back(n);
  return list;
}

TEST(DenseCholesky, ReproducesTheMatrixInEveryInstructionSet) {
  for (const InstructionSet set : runnable_sets()) {
    for (const std::int64_t n : orders()) {
      const MatrixXd A = random_spd(n, static_cast<unsigned>(n));
      MatrixXd L = A;
      ASSERT_TRUE(factor_in_place(L, 1, set)) << name(set) << ", order " << n;
      // Backward error bound of Cholesky: |A - L L^T| <= (n + 1) eps |L| |L^T|, entry by entry.
      const double bound = static_cast<double>(n + 3) * eps;
      EXPECT_LE(scaled_residual(A, L), bound) << name(set) << ", order " << n;
    }
  }
}

TEST(DenseCholesky, AgreesWithEigenOnLargeOrders) {
  for (const InstructionSet set : runnable_sets()) {
    for (const std::int64_t n : {441, 513, 700}) {
      const MatrixXd A = random_spd(n, static_cast<unsigned>(n));
      const MatrixXd expected = A.llt().matrixL();
      for (const int threads : {1, 2}) {
        MatrixXd L = A;
        ASSERT_TRUE(factor_in_place(L, threads, set));
        EXPECT_LE((lower(L) - expected).norm(), 1e-10 * expected.norm())
            << name(set) << ", order " << n << ", " << threads << " threads";
      }
    }
  }
}

TEST(DenseCholesky, BadScalingCostsNoAccuracy) {
  for (const InstructionSet set : runnable_sets()) {
    for (const std::int64_t n : {2, 9, 30, 97, 200}) {
      const MatrixXd A = badly_scaled(n, static_cast<unsigned>(n));
      MatrixXd L = A;
      ASSERT_TRUE(factor_in_place(L, 2, set)) << name(set) << ", order " << n;
      EXPECT_LE(scaled_residual(A, L), static_cast<double>(n + 3) * eps);
    }
  }
}

TEST(DenseCholesky, SameBitsForAnyNumberOfThreads) {
  for (const InstructionSet set : runnable_sets()) {
    for (const std::int64_t n : {150, 189, 441, 530, 801}) {
      const MatrixXd A = random_spd(n, static_cast<unsigned>(n));
      MatrixXd one = A;
      ASSERT_TRUE(factor_in_place(one, 1, set));
      for (const int threads : {2, 3, 7}) {
        MatrixXd L = A;
        ASSERT_TRUE(factor_in_place(L, threads, set));
        EXPECT_TRUE(lower(L) == lower(one)) << name(set) << ", " << n << ", " << threads;
      }
    }
  }
}

TEST(DenseCholesky, CanBeReused) {
  const std::int64_t n = 300;
  ThreadPool pool(2);
  DenseCholesky cholesky(n);
  EXPECT_EQ(cholesky.order(), n);
  MatrixXd bad = MatrixXd::Constant(n, n, 1.0);
  EXPECT_FALSE(cholesky.factor(bad.data(), n, pool));
  for (const unsigned seed : {1U, 2U}) {
    const MatrixXd A = random_spd(n, seed);
    MatrixXd L = A;
    ASSERT_TRUE(cholesky.factor(L.data(), n, pool));
    EXPECT_LE(scaled_residual(A, L), static_cast<double>(n + 3) * eps);
  }
}

TEST(DenseCholesky, TouchesTheLowerTriangleOnly) {
  for (const InstructionSet set : runnable_sets()) {
    for (const std::int64_t n : {1, 5, 24, 31, 64, 189, 260}) {
      const std::int64_t ld = n + 5;
      MatrixXd A =
          MatrixXd::Constant(ld, n, nan);  // also: what is not read cannot spoil the result
      const MatrixXd original = random_spd(n, 3);
      A.topRows(n).triangularView<Eigen::Lower>() = original;
      ThreadPool pool(2);
      DenseCholesky cholesky(n, set);
      ASSERT_TRUE(cholesky.factor(A.data(), ld, pool));
      EXPECT_LE(scaled_residual(original, lower(A.topRows(n))), static_cast<double>(n + 3) * eps);
      for (std::int64_t c = 0; c < n; ++c) {
        EXPECT_TRUE(A.col(c).head(c).array().isNaN().all()) << "above the diagonal, column " << c;
        EXPECT_TRUE(A.col(c).tail(ld - n).array().isNaN().all()) << "padding, column " << c;
      }
      VectorXd b = VectorXd::Ones(n);
      cholesky.solve(A.data(), ld, b.data());
      EXPECT_LE((original * b - VectorXd::Ones(n)).norm(),
                1e-8 * std::sqrt(static_cast<double>(n)));
    }
  }
}

TEST(DenseCholesky, SolvesAsAccuratelyAsEigen) {
  for (const InstructionSet set : runnable_sets()) {
    for (const std::int64_t n : {1, 2, 7, 8, 9, 15, 16, 17, 63, 70, 144, 441}) {
      const MatrixXd A = random_spd(n, static_cast<unsigned>(n));
      const VectorXd b = random_matrix(n, 1, 11);
      MatrixXd L = A;
      ASSERT_TRUE(factor_in_place(L, 1, set));
      VectorXd x = b;
      DenseCholesky(n, set).solve(L.data(), n, x.data());
      // Normwise backward error.
      EXPECT_LE((A * x - b).norm(), 10.0 * static_cast<double>(n) * eps * A.norm() * x.norm())
          << name(set) << ", order " << n;
    }
  }
}

TEST(DenseCholesky, OrderZeroIsDone) {
  ThreadPool pool(1);
  DenseCholesky cholesky(0);
  EXPECT_TRUE(cholesky.factor(nullptr, 1, pool));
  cholesky.solve(nullptr, 1, nullptr);
}

/// A row and column k that make the matrix indefinite only at pivot k.
MatrixXd indefinite_at(std::int64_t n, std::int64_t k) {
  MatrixXd A = random_spd(n, 5);
  const MatrixXd L = A.llt().matrixL();
  A(k, k) -= 1.01 * L(k, k) * L(k, k);
  return A;
}

TEST(DenseCholesky, RefusesIndefiniteMatrices) {
  for (const InstructionSet set : runnable_sets()) {
    for (const std::int64_t n : {1, 2, 9, 25, 70, 189, 450}) {
      for (const std::int64_t k : {std::int64_t{0}, n / 2, n - 1}) {
        for (const int threads : {1, 3}) {
          MatrixXd A = indefinite_at(n, k);
          EXPECT_FALSE(factor_in_place(A, threads, set)) << name(set) << ", " << n << ", " << k;
        }
      }
    }
  }
}

TEST(DenseCholesky, RefusesWhatIsNotFinite) {
  for (const InstructionSet set : runnable_sets()) {
    for (const std::int64_t n : {1, 10, 60, 200}) {
      for (const double bad : {nan, inf, -inf}) {
        for (const std::int64_t row : {std::int64_t{0}, n / 2, n - 1}) {
          for (const std::int64_t column : {std::int64_t{0}, row / 2, row}) {
            MatrixXd A = random_spd(n, 5);
            A(row, column) = bad;
            EXPECT_FALSE(factor_in_place(A, 2, set)) << n << ": " << row << ", " << column;
          }
        }
      }
    }
  }
}

TEST(DenseCholesky, RefusesZeroAndSingularMatricesAtAnyScale) {
  for (const InstructionSet set : runnable_sets()) {
    for (const std::int64_t n : {8, 50, 144}) {
      MatrixXd zero = MatrixXd::Zero(n, n);
      EXPECT_FALSE(factor_in_place(zero, 1, set));
      for (const double scale : {1e-60, 1.0, 1e60}) {
        MatrixXd ones = MatrixXd::Constant(n, n, scale);  // rank 1
        EXPECT_FALSE(factor_in_place(ones, 1, set));
      }
    }
  }
}

TEST(DenseCholesky, VerdictIgnoresPowerOfTwoScaling) {
  // Pivots of relative size 2^-k: accepted or refused alike when rows and columns are scaled.
  const std::int64_t n = 40;
  int accepted = 0;
  for (int k = 40; k <= 54; ++k) {
    MatrixXd A = MatrixXd::Identity(n, n);
    A(n - 1, n - 2) = A(n - 2, n - 1) = 1.0 - std::ldexp(1.0, -k);
    const VectorXd scale = VectorXd::NullaryExpr(
        n, [](Eigen::Index i) { return std::ldexp(1.0, 13 * (int(i) % 7 - 3)); });
    MatrixXd scaled = scale.asDiagonal() * A * scale.asDiagonal();
    const bool verdict = factor_in_place(A, 1);
    EXPECT_EQ(factor_in_place(scaled, 1), verdict) << "2^-" << k;
    accepted += verdict ? 1 : 0;
  }
  EXPECT_GT(accepted, 5);
  EXPECT_LT(accepted, 15);
}

TEST(InstructionSets, AreNamedAndNeverAboveTheDetectedOne) {
  EXPECT_LE(instruction_set(), detected_instruction_set());
  EXPECT_EQ(name(InstructionSet::baseline), "baseline");
  EXPECT_EQ(name(InstructionSet::avx2), "avx2");
  EXPECT_EQ(name(InstructionSet::avx512), "avx512");
}

}  // namespace
}  // namespace raybundle::linalg
