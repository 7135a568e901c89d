// Factors of inverses, and of generalised inverses where a block has not the full rank.

#include <raybundle/linalg/block_factor.h>

#include <cstdint>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/QR>

#include <raybundle/tests/support/random_problem.h>

namespace raybundle::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

RowMajor random_matrix(std::int64_t rows, std::int64_t columns, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  return RowMajor::NullaryExpr(rows, columns, [&] { return test::uniform(random); });
}

RowMajor factor_of(const RowMajor& A) {
  RowMajor M = RowMajor::Constant(A.rows(), A.cols(), 1e300);
  inverse_factor(A.data(), static_cast<int>(A.rows()), M.data());
  return M;
}

TEST(BlockFactor, InvertsDefiniteBlocksOfEverySize) {
  for (int n = 1; n <= 12; ++n) {
    const RowMajor B = random_matrix(n + 4, n, static_cast<std::uint64_t>(n));
    const RowMajor A = B.transpose() * B + 0.1 * RowMajor::Identity(n, n);
    const RowMajor M = factor_of(A);
    EXPECT_LE((A * M * M.transpose() - RowMajor::Identity(n, n)).norm(), 1e-10) << n;
  }
}

TEST(BlockFactor, UnitsDoNotMatter) {
  const RowMajor B = random_matrix(12, 9, 3);
  VectorXd s(9);
  s << 1e-9, 1, 1e9, 1e-3, 1e3, 1, 1e6, 1e-6, 1e2;
  const RowMajor A = s.asDiagonal() * RowMajor(B.transpose() * B) * s.asDiagonal();
  const RowMajor M = factor_of(A);
  const RowMajor identity =
      s.asDiagonal() * (M * M.transpose()).eval() * s.asDiagonal() * RowMajor(B.transpose() * B);
  EXPECT_LE((identity - RowMajor::Identity(9, 9)).norm(), 1e-9);
}

// With G = M M^T: A G A = A (nothing that has information is lost) and G A G = G (nothing else is
// invented), for any rank.
TEST(BlockFactor, SemidefiniteBlocksGiveAGeneralisedInverse) {
  for (const int n : {3, 6, 9}) {
    for (int rank = 0; rank < n; ++rank) {
      const RowMajor B = random_matrix(rank, n, static_cast<std::uint64_t>(10 * n + rank));
      const RowMajor A = B.transpose() * B;
      const RowMajor M = factor_of(A);
      const RowMajor G = M * M.transpose();
      EXPECT_LE((A * G * A - A).norm(), 1e-12 * A.norm()) << n << ", rank " << rank;
      EXPECT_LE((G * A * G - G).norm(), 1e-9 * G.norm()) << n << ", rank " << rank;
      EXPECT_EQ(Eigen::ColPivHouseholderQR<MatrixXd>(M).rank(), rank);
    }
  }
}

TEST(BlockFactor, ZeroAndNonFiniteBlocksGiveNoStep) {
  EXPECT_TRUE(factor_of(RowMajor::Zero(3, 3)).isZero(0));
  for (const double bad : {nan, inf, -inf}) {
    RowMajor A = RowMajor::Identity(9, 9);
    A(4, 4) = bad;
    EXPECT_TRUE(factor_of(A).isZero(0)) << bad;
    A = RowMajor::Identity(9, 9);
    A(2, 1) = A(1, 2) = bad;
    EXPECT_TRUE(factor_of(A).isZero(0)) << bad;
  }
}

TEST(BlockFactor, UnknownsWithoutAnyInformationKeepAnExactZero) {
  RowMajor A = RowMajor::Zero(9, 9);
  const RowMajor B = random_matrix(9, 7, 8);
  A.topLeftCorner(7, 7) = B.transpose() * B;  // two unknowns are held fixed
  const RowMajor M = factor_of(A);
  EXPECT_TRUE(M.bottomRows(2).isZero(0));
  const RowMajor G = M * M.transpose();
  EXPECT_LE((A * G * A - A).norm(), 1e-12 * A.norm());
}

}  // namespace
}  // namespace raybundle::linalg
