// Dense and sparse factorisation of block matrices behind one interface, against Eigen.

#include <raybundle/linalg/cholesky.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <raybundle/linalg/cholmod_cholesky.h>
#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/ordering.h>
#include <raybundle/tests/support/block_system.h>

namespace raybundle::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = CholeskyKind;
using Storage = SymmetricBlocks::Storage;
using Edges = std::vector<std::pair<std::int32_t, std::int32_t>>;  // (a, b), a < b, sorted

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

SymmetricPattern pattern_of(const std::vector<int>& sizes, const Edges& edges) {
  SymmetricPattern pattern;
  pattern.offset = {0};
  for (const int size : sizes) pattern.offset.push_back(pattern.offset.back() + size);
  pattern.row_begin = {0};
  auto edge = edges.begin();
  for (std::int32_t a = 0; a < static_cast<std::int32_t>(sizes.size()); ++a) {
    pattern.column.push_back(a);
    for (; edge != edges.end() && edge->first == a; ++edge) pattern.column.push_back(edge->second);
    pattern.row_begin.push_back(static_cast<std::int64_t>(pattern.column.size()));
  }
  return pattern;
}

Edges chain(std::int32_t count, std::int32_t reach) {
  Edges edges;
  for (std::int32_t a = 0; a < count; ++a) {
    for (std::int32_t b = a + 1; b < std::min(count, a + 1 + reach); ++b) edges.emplace_back(a, b);
  }
  return edges;
}

Edges grid(std::int32_t side) {
  Edges edges;
  for (std::int32_t a = 0; a < side * side; ++a) {
    if ((a + 1) % side != 0) edges.emplace_back(a, a + 1);
    if (a + side < side * side) edges.emplace_back(a, a + side);
  }
  return edges;
}

std::vector<int> mixed_sizes(int count) {
  std::vector<int> sizes;
  for (int a = 0; a < count; ++a) sizes.push_back(a % 3 == 0 ? 9 : 3);
  return sizes;
}

// Random numbers in the pattern, made definite by a dominant diagonal.
MatrixXd random_spd(const SymmetricPattern& pattern, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  MatrixXd A = MatrixXd::Zero(pattern.order(), pattern.order());
  for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
    for (std::int64_t p = pattern.row_begin[index(a)]; p < pattern.row_begin[index(a + 1)]; ++p) {
      const std::int64_t b = pattern.column[index(p)];
      const MatrixXd block = MatrixXd::NullaryExpr(pattern.block_size(a), pattern.block_size(b),
                                                   [&] { return test::uniform(random); });
      A.block(pattern.offset[index(a)], pattern.offset[index(b)], block.rows(), block.cols()) =
          block;
    }
  }
  MatrixXd S = A.selfadjointView<Eigen::Upper>();
  S.diagonal() = S.cwiseAbs().rowwise().sum().array() + 0.1;
  return S;
}

// A x, from the stored triangle.
VectorXd multiply_upper(SymmetricBlocks& A, const VectorXd& x) {
  const SymmetricPattern& pattern = A.pattern();
  VectorXd y = VectorXd::Zero(pattern.order());
  for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
    for (std::int64_t i = 0; i < pattern.block_size(a); ++i) {
      const double* row = A.row(a) + i * A.stride(a);
      const Eigen::Index from = pattern.offset[index(a)] + i;
      for (std::int64_t p = pattern.row_begin[index(a)]; p < pattern.row_begin[index(a + 1)]; ++p) {
        const std::int64_t b = pattern.column[index(p)];
        for (std::int64_t k = 0; k < pattern.block_size(b); ++k) {
          const Eigen::Index to = pattern.offset[index(b)] + k;
          if (to < from) continue;
          y[from] += row[A.block_shift(p) + k] * x[to];
          if (to != from) y[to] += row[A.block_shift(p) + k] * x[from];
        }
      }
    }
  }
  return y;
}

struct Case {
  std::string name;
  SymmetricPattern pattern;
};

std::vector<Case> cases() {
  return {{"OneBlock", pattern_of({9}, {})},
          {"DiagonalOnly", pattern_of({9, 3, 6, 3}, {})},
          {"Full", pattern_of(std::vector<int>(20, 6), chain(20, 20))},
          {"Chain", pattern_of(std::vector<int>(60, 9), chain(60, 3))},
          {"MixedSizes", pattern_of(mixed_sizes(50), chain(50, 4))},
          {"Grid", pattern_of(std::vector<int>(144, 3), grid(12))},
          {"Arrow", pattern_of({3, 9, 3, 3, 6}, {{0, 4}, {1, 4}, {2, 4}, {3, 4}})}};
}

class CholeskyOf : public ::testing::TestWithParam<std::tuple<Case, Kind>> {
 protected:
  const SymmetricPattern& pattern() const { return std::get<0>(GetParam()).pattern; }
  ThreadPool pool_{2};
  std::unique_ptr<Cholesky> cholesky_ =
      Cholesky::make(plan_cholesky(pattern(), 2, std::get<1>(GetParam())), pool_);
};

TEST_P(CholeskyOf, SolvesAgainAndAgain) {
  EXPECT_EQ(cholesky_->kind(), std::get<1>(GetParam()));
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const MatrixXd A = random_spd(pattern(), seed);
    test::write_dense(A, cholesky_->matrix());
    ASSERT_TRUE(cholesky_->factor());
    for (int k = 0; k < 2; ++k) {  // more than one right side per factor
      const VectorXd b = VectorXd::LinSpaced(A.rows(), -1, 1 + k);
      VectorXd x = b;
      cholesky_->solve(x.data());
      EXPECT_LE((A * x - b).norm(), 1e-13 * (A.norm() * x.norm() + b.norm()));
      EXPECT_LE((x - A.llt().solve(b)).norm(), 1e-11 * x.norm());
    }
  }
}

TEST_P(CholeskyOf, RefusesIndefiniteMatricesAndRecovers) {
  const MatrixXd good = random_spd(pattern(), 4);
  for (const std::int64_t at : {std::int64_t{0}, pattern().order() / 2, pattern().order() - 1}) {
    MatrixXd bad = good;
    bad(at, at) = -1;
    test::write_dense(bad, cholesky_->matrix());
    EXPECT_FALSE(cholesky_->factor()) << "diagonal " << at;
    bad(at, at) = 0;
    test::write_dense(bad, cholesky_->matrix());
    EXPECT_FALSE(cholesky_->factor()) << "diagonal " << at;
    test::write_dense(good, cholesky_->matrix());
    ASSERT_TRUE(cholesky_->factor());
    const VectorXd b = VectorXd::Ones(good.rows());
    VectorXd x = b;
    cholesky_->solve(x.data());
    EXPECT_LE((good * x - b).norm(), 1e-12 * b.norm());
  }
}

TEST_P(CholeskyOf, RefusesWhatIsNotFinite) {
  const MatrixXd good = random_spd(pattern(), 5);
  for (const std::int64_t at : {std::int64_t{0}, pattern().order() / 2, pattern().order() - 1}) {
    for (const double value : {nan, inf}) {
      MatrixXd bad = good;
      bad(at, at) = value;
      test::write_dense(bad, cholesky_->matrix());
      EXPECT_FALSE(cholesky_->factor()) << value << " on diagonal " << at;
      if (at + 1 < good.rows() && good(at, at + 1) != 0) {
        bad = good;
        bad(at, at + 1) = bad(at + 1, at) = value;
        test::write_dense(bad, cholesky_->matrix());
        EXPECT_FALSE(cholesky_->factor()) << value << " beside diagonal " << at;
      }
    }
  }
}

// Every unknown of a bundle adjustment has its own unit.
TEST_P(CholeskyOf, UnitsDoNotMatter) {
  std::mt19937_64 random(7);
  const MatrixXd A = random_spd(pattern(), 6);
  const VectorXd s =
      VectorXd::NullaryExpr(A.rows(), [&] { return std::pow(10.0, 9 * test::uniform(random)); });
  test::write_dense(s.asDiagonal() * A * s.asDiagonal(), cholesky_->matrix());
  ASSERT_TRUE(cholesky_->factor());
  const VectorXd b = VectorXd::Ones(A.rows());
  VectorXd x = s.asDiagonal() * b;
  cholesky_->solve(x.data());
  EXPECT_LE((A * (s.asDiagonal() * x) - b).norm(), 1e-11 * b.norm());
}

constexpr std::array kinds = {Kind::dense, Kind::sparse, Kind::cholmod};
constexpr std::array kind_names = {"Dense", "Sparse", "Cholmod"};

INSTANTIATE_TEST_SUITE_P(Patterns, CholeskyOf,
                         ::testing::Combine(::testing::ValuesIn(cases()),
                                            ::testing::ValuesIn(kinds)),
                         [](const auto& test) {
                           const auto kind = static_cast<std::size_t>(std::get<1>(test.param));
                           return std::get<0>(test.param).name + kind_names[kind];
                         });

// A matrix whose last unknown says nothing new: exactly singular, up to rounding.
TEST(Cholesky, RefusesSingularMatricesOfEveryKind) {
  const SymmetricPattern pattern = pattern_of(std::vector<int>(20, 6), chain(20, 20));
  std::array<int, kinds.size()> refused = {};
  constexpr int trials = 20;
  for (int trial = 0; trial < trials; ++trial) {
    std::mt19937_64 random(static_cast<std::uint64_t>(trial));
    MatrixXd B = MatrixXd::NullaryExpr(140, 120, [&] { return test::uniform(random); });
    B.col(119) = B.col(3) - 0.5 * B.col(60);
    ThreadPool pool(1);
    for (std::size_t k = 0; k < kinds.size(); ++k) {
      const auto cholesky = Cholesky::make(plan_cholesky(pattern, 1, kinds[k]), pool);
      test::write_dense(B.transpose() * B, cholesky->matrix());
      if (!cholesky->factor()) ++refused[k];
    }
  }
  for (std::size_t k = 0; k < kinds.size(); ++k) EXPECT_EQ(refused[k], trials) << kind_names[k];
}

TEST(Cholesky, ChoosesDenseOrSparse) {
  const auto kind = [](const SymmetricPattern& pattern) { return plan_cholesky(pattern, 1).kind; };
  EXPECT_EQ(kind(pattern_of(std::vector<int>(20, 9), chain(20, 1))), Kind::dense)
      << "small: not worth an analysis";
  EXPECT_EQ(kind(pattern_of(std::vector<int>(100, 9), chain(100, 100))), Kind::dense) << "full";
  EXPECT_EQ(kind(pattern_of(std::vector<int>(400, 9), chain(400, 2))), Kind::sparse)
      << "a long chain";
}

TEST(Cholesky, RefusesWhatDoesNotFitAndSaysHowMuchItWouldTake) {
  ThreadPool pool(1);
  for (const Kind kind : kinds) {
    CholeskyPlan plan = plan_cholesky(pattern_of({9}, {}), 1, kind);
    plan.memory = 1e18;
    try {
      static_cast<void>(Cholesky::make(std::move(plan), pool));
      ADD_FAILURE() << "not refused";
    } catch (const MemoryRefusal& refusal) {
      const std::string text = refusal.what();
      EXPECT_NE(text.find("1000000000.0 GB"), std::string::npos) << text;
      EXPECT_NE(text.find("factorisation of order 9"), std::string::npos) << text;
    }
  }
}

TEST(Cholesky, DescriptionsNameTheWay) {
  ThreadPool pool(1);
  const SymmetricPattern pattern = pattern_of(std::vector<int>(10, 9), chain(10, 1));
  const auto describe = [&](Kind kind) {
    return Cholesky::make(plan_cholesky(pattern, 1, kind), pool)->description();
  };
  EXPECT_NE(describe(Kind::dense).find("dense Cholesky of order 90"), std::string::npos);
  EXPECT_NE(describe(Kind::sparse).find("sparse Cholesky of order 90"), std::string::npos);
  EXPECT_EQ(describe(Kind::sparse).find("CHOLMOD"), std::string::npos);
  EXPECT_NE(describe(Kind::cholmod).find("CHOLMOD"), std::string::npos);
}

// A chain has no fill under minimum degree, a large grid has less under nested dissection.
TEST(Ordering, KeepsTheOneWithLessFill) {
  const Ordering line = find_ordering(pattern_of(std::vector<int>(300, 9), chain(300, 1)));
  EXPECT_EQ(line.method, "minimum degree");
  EXPECT_NEAR(line.nonzeros, 599 * 81.0, 1e-6) << "300 + 299 blocks, no fill";
  EXPECT_EQ(find_ordering(pattern_of(std::vector<int>(60 * 60, 3), grid(60))).method,
            "nested dissection");
}

TEST(Ordering, IsAPermutation) {
  for (const Case& c : cases()) {
    std::vector<std::int64_t> sorted = find_ordering(c.pattern).permutation;
    std::sort(sorted.begin(), sorted.end());
    ASSERT_EQ(static_cast<std::int64_t>(sorted.size()), c.pattern.blocks()) << c.name;
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      EXPECT_EQ(sorted[i], static_cast<std::int64_t>(i)) << c.name;
    }
  }
}

TEST(Ordering, PredictsTheWorkOfAFullMatrix) {
  const Ordering full = find_ordering(pattern_of(std::vector<int>(40, 6), chain(40, 40)));
  const double n = 240;
  EXPECT_NEAR(full.flops, n * n * n / 3, 0.1 * n * n * n / 3);
  EXPECT_NEAR(full.nonzeros, n * n / 2, 0.1 * n * n / 2);
}

TEST(CholmodCholesky, SolvesUnderNestedDissection) {
  const SymmetricPattern plane = pattern_of(std::vector<int>(60 * 60, 3), grid(60));
  CholmodCholesky cholesky(plane, find_ordering(plane));
  SymmetricBlocks A(plane, Storage::sparse);
  std::mt19937_64 random(9);
  for (std::int64_t a = 0; a < plane.blocks(); ++a) {
    for (std::int64_t i = 0; i < 3; ++i) {
      double* row = A.row(a) + i * A.stride(a);
      for (std::int64_t k = 0; k < A.stride(a); ++k) row[k] = test::uniform(random);
      row[i] = 40;
    }
  }
  ASSERT_TRUE(cholesky.factor(A));
  const VectorXd ones = VectorXd::Ones(plane.order());
  VectorXd x = ones;
  cholesky.solve(x.data());
  EXPECT_LE((multiply_upper(A, x) - ones).norm(), 1e-12 * ones.norm());
}

}  // namespace
}  // namespace raybundle::linalg
