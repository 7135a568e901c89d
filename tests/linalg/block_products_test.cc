// Products with the block Jacobian and its normal equations, against the dense matrix.

#include <raybundle/linalg/block_jacobian.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <raybundle/linalg/cpu.h>
#include <raybundle/linalg/normal_equations.h>
#include <raybundle/tests/support/block_system.h>

namespace raybundle::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::BlockSystem;
using test::BlockSystemOptions;
using test::form;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double tolerance = 1e-13;

VectorXd random_vector(std::int64_t size, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  return VectorXd::NullaryExpr(size, [&] { return test::uniform(random); });
}

MatrixXd block_of(const std::vector<double>& blocks, std::int64_t b, int size) {
  return Eigen::Map<const RowMajor>(blocks.data() + b * size * size, size, size);
}

class BlockProducts : public ::testing::TestWithParam<BlockSystemOptions> {
 protected:
  BlockSystem system_{GetParam()};
  ThreadPool pool_{3};
};

TEST_P(BlockProducts, Multiply) {
  const VectorXd x = random_vector(system_.layout.unknowns(), 1);
  VectorXd u = VectorXd::Constant(system_.layout.residuals(), 1e300);
  multiply(system_.J, x.data(), u.data(), pool_);
  EXPECT_LE((u - system_.dense * x).norm(), tolerance * x.norm());
}

TEST_P(BlockProducts, Squares) {
  const VectorXd x = random_vector(system_.layout.unknowns(), 5);
  const double exact = (system_.dense * x).squaredNorm();
  EXPECT_NEAR(multiply_squares(system_.J, x.data(), pool_), exact, tolerance * exact);
}

TEST_P(BlockProducts, TransposeMultiply) {
  const VectorXd u = random_vector(system_.layout.residuals(), 2);
  VectorXd y = VectorXd::Constant(system_.layout.unknowns(), 1e300);
  transpose_multiply(system_.J, u.data(), y.data(), pool_);
  EXPECT_LE((y - system_.dense.transpose() * u).norm(), tolerance * system_.dense.norm());
}

TEST_P(BlockProducts, TransposeMultiplyOfOneSideTouchesNothingElse) {
  const VectorXd u = random_vector(system_.layout.residuals(), 3);
  const VectorXd expected = system_.dense.transpose() * u;
  const VectorXd of_leaves = expected.tail(system_.layout.size(Side::leaves));
  for (const Side side : {Side::hubs, Side::leaves}) {
    const std::int64_t size = system_.layout.size(side);
    VectorXd y = VectorXd::Constant(size + 1, 77);
    if (side == Side::hubs) {
      transpose_multiply_hubs(system_.J, u.data(), of_leaves.data(), y.data(), pool_);
    } else {
      transpose_multiply_leaves(system_.J, u.data(), y.data(), pool_);
    }
    EXPECT_LE((y.head(size) - expected.segment(system_.layout.offset(side), size)).norm(),
              tolerance * system_.dense.norm());
    EXPECT_EQ(y[size], 77);
  }
}

TEST_P(BlockProducts, NormalEquations) {
  NormalEquations& normal = system_.normal;
  form(normal, system_.J, system_.r.data(), pool_);
  const MatrixXd H = system_.dense.transpose() * system_.dense;
  const VectorXd g = system_.gradient();
  EXPECT_LE((Eigen::Map<VectorXd>(normal.gradient.data(), g.size()) - g).norm(),
            tolerance * system_.dense.norm());
  for (const Side side : {Side::hubs, Side::leaves}) {
    const int size = system_.layout.block_size(side);
    std::vector<double> blocks;
    normal.diagonal_blocks(system_.J, side, blocks, pool_);
    for (std::int64_t b = 0; b < system_.layout.block_count(side); ++b) {
      const std::int64_t at = system_.layout.offset(side) + b * size;
      const MatrixXd block = block_of(blocks, b, size);
      EXPECT_LE((block - H.block(at, at, size, size)).norm(), tolerance * H.norm());
      EXPECT_LE((block - block.transpose()).norm(), 1e-15 * H.norm());
    }
  }
}

TEST_P(BlockProducts, DiagonalIsClampedOnBothEnds) {
  form(system_.normal, system_.J, system_.r.data(), pool_);
  const VectorXd exact = system_.dense.colwise().squaredNorm();
  VectorXd d(system_.layout.unknowns());
  system_.normal.diagonal(0.0, 1e300, d.data(), pool_);
  EXPECT_LE((d - exact).norm(), tolerance * exact.norm());
  system_.normal.diagonal(0.4, 0.9, d.data(), pool_);
  EXPECT_LE((d - exact.cwiseMax(0.4).cwiseMin(0.9)).norm(), tolerance * exact.norm());
}

TEST_P(BlockProducts, SameBitsForAnyNumberOfThreads) {
  const VectorXd x = random_vector(system_.layout.unknowns(), 4);
  std::vector<VectorXd> products;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    VectorXd u(system_.layout.residuals()), y(system_.layout.unknowns());
    multiply(system_.J, x.data(), u.data(), pool);
    transpose_multiply(system_.J, u.data(), y.data(), pool);
    NormalEquations normal(system_.layout);
    form(normal, system_.J, u.data(), pool);
    std::vector<double> B;
    normal.diagonal_blocks(system_.J, Side::hubs, B, pool);
    VectorXd all(y.size() + static_cast<Eigen::Index>(B.size()));
    all << y, Eigen::Map<VectorXd>(B.data(), static_cast<Eigen::Index>(B.size()));
    products.push_back(all);
  }
  EXPECT_TRUE(products[0] == products[1]);
  EXPECT_TRUE(products[0] == products[2]);
}

INSTANTIATE_TEST_SUITE_P(Systems, BlockProducts, ::testing::ValuesIn(test::typical_systems()),
                         [](const auto& test) { return test::name(test.param); });
INSTANTIATE_TEST_SUITE_P(Anchored, BlockProducts, ::testing::ValuesIn(test::anchored_systems()),
                         [](const auto& test) { return test::name(test.param); });

// The environment variable that lowers the instruction set is what the other runs of these tests
// rely on.
TEST(InstructionSet, ObeysTheEnvironment) {
  const char* const wish = std::getenv("RAYBUNDLE_ISA");
  if (wish == nullptr) {
    EXPECT_EQ(instruction_set(), detected_instruction_set());
  } else if (std::string(wish) == "baseline") {
    EXPECT_EQ(instruction_set(), InstructionSet::baseline);
  } else if (std::string(wish) == "avx2") {
    EXPECT_EQ(instruction_set(), std::min(InstructionSet::avx2, detected_instruction_set()));
  }
}

}  // namespace
}  // namespace raybundle::linalg
