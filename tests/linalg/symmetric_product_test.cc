// The product with stored symmetric blocks, and the reduced system on it, against dense matrices.

#include <raybundle/linalg/symmetric_product.h>

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <raybundle/linalg/explicit_system.h>
#include <raybundle/linalg/schur_complement.h>
#include <raybundle/tests/support/block_system.h>

namespace raybundle::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Blocks of all sizes up to 12, each beside those at some distances.
SymmetricPattern mixed_pattern(int blocks) {
  SymmetricPattern pattern;
  pattern.offset = {0};
  pattern.row_begin = {0};
  for (int a = 0; a < blocks; ++a) {
    pattern.offset.push_back(pattern.offset.back() + 1 + a % 12);
    for (const int apart : {0, 1, 2, 5, 9, 17, 40}) {
      if (a + apart < blocks) pattern.column.push_back(a + apart);
    }
    pattern.row_begin.push_back(static_cast<std::int64_t>(pattern.column.size()));
  }
  return pattern;
}

TEST(SymmetricProduct, IsThatOfTheWholeMatrixInEveryInstructionSet) {
  for (const int blocks : {1, 3, 200}) {
    const SymmetricPattern pattern = mixed_pattern(blocks);
    SymmetricBlocks A(pattern, SymmetricBlocks::Storage::sparse);
    std::mt19937_64 random(8);
    for (std::int64_t i = 0; i < pattern.scalar_nonzeros(); ++i) {
      A.values()[i] = test::uniform(random);
    }
    const MatrixXd whole = test::dense_of(A);
    const VectorXd x = VectorXd::LinSpaced(pattern.order(), -1, 2);
    for (const auto set :
         {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
      if (set > detected_instruction_set()) continue;
      SymmetricProduct product(A.pattern(), set);
      VectorXd first;
      for (const int threads : {1, 2, 3}) {
        ThreadPool pool(threads);
        VectorXd y = VectorXd::Constant(x.size(), 1e300);
        product.multiply(A, x.data(), y.data(), pool);
        EXPECT_LE((y - whole * x).norm(), 1e-13 * whole.norm() * x.norm()) << name(set);
        if (threads == 1) first = y;
        EXPECT_EQ(y, first) << "bits, " << threads << " threads";
      }
    }
  }
}

class ExplicitSystems : public ::testing::TestWithParam<test::BlockSystemOptions> {};

TEST_P(ExplicitSystems, AreTheImplicitOnes) {
  test::BlockSystem system(GetParam());
  ThreadPool pool(2);
  for (const Side side : {Side::leaves, Side::hubs}) {
    SchurComplement implicit(system.layout, side, pool);
    ExplicitSystem formed(make_reduced_system(system.layout, side, pool), implicit.pattern(), pool);
    const Linearization at = system.linearization(pool);
    implicit.prepare(at, system.D.data());
    formed.prepare(at, system.D.data());
    const auto size = static_cast<Eigen::Index>(implicit.size());
    ASSERT_EQ(formed.size(), size);
    EXPECT_EQ(formed.offset(), implicit.offset());

    const VectorXd x = VectorXd::LinSpaced(size, -1, 1);
    VectorXd y(size), expected(size), v(size), expected_v(size);
    implicit.apply(x.data(), expected.data());
    formed.apply(x.data(), y.data());
    EXPECT_LE((y - expected).norm(), 1e-12 * system.dense.squaredNorm() * x.norm());

    DiagonalBlocks blocks, expected_blocks;
    implicit.reduced_diagonal(expected_blocks, expected_v.data());
    formed.reduced_diagonal(blocks, v.data());
    EXPECT_LE((v - expected_v).norm(), 1e-12 * system.gradient().norm());
    ASSERT_EQ(blocks.runs.size(), 1U);
    ASSERT_EQ(blocks.runs[0].count, expected_blocks.runs[0].count);
    for (std::size_t i = 0; i < blocks.runs[0].values.size(); ++i) {
      EXPECT_NEAR(blocks.runs[0].values[i], expected_blocks.runs[0].values[i],
                  1e-12 * system.dense.squaredNorm());
    }
    VectorXd step(system.layout.unknowns()), expected_step(system.layout.unknowns());
    EXPECT_EQ(formed.expand(x.data(), step.data()),
              implicit.expand(x.data(), expected_step.data()));
    EXPECT_EQ(step, expected_step);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, ExplicitSystems, ::testing::ValuesIn(test::typical_systems()),
                         [](const auto& test) { return test::name(test.param); });

}  // namespace
}  // namespace raybundle::linalg
