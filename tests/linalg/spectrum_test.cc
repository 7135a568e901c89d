// Eigenvalues of diagonal blocks and of the reduced system against dense ones.

#include <raybundle/linalg/spectrum.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <raybundle/tests/support/block_system.h>
#include <raybundle/tests/support/random_problem.h>

namespace raybundle::linalg {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Blocks {
  std::vector<double> values, damping;
  Eigen::MatrixXd dense;
};

Blocks random_blocks(int size, int count, unsigned seed) {
  std::mt19937_64 random(seed);
  Blocks blocks;
  blocks.dense = Eigen::MatrixXd::Zero(size * count, size * count);
  for (int b = 0; b < count; ++b) {
    const RowMajor J =
        RowMajor::NullaryExpr(size + 1, size, [&] { return test::uniform(random); }) *
        std::pow(10.0, test::uniform(random));
    const RowMajor H = J.transpose() * J;
    blocks.values.insert(blocks.values.end(), H.data(), H.data() + H.size());
    blocks.dense.block(b * size, b * size, size, size) = H;
    for (int i = 0; i < size; ++i) {
      blocks.damping.push_back(0.1 * (1 + test::uniform(random)));
      blocks.dense(b * size + i, b * size + i) += blocks.damping.back();
    }
  }
  return blocks;
}

double condition(const Blocks& blocks, int size, int threads = 2) {
  ThreadPool pool(threads);
  const auto count = static_cast<std::int64_t>(blocks.values.size()) / (size * size);
  return block_spectrum(blocks.values.data(), size, count, blocks.damping.data(), pool)
      .worst_condition;
}

TEST(Condition, IsThatOfTheWorstBlock) {
  for (const int size : {3, 6, 9}) {
    for (const int count : {1, 5, 40}) {
      const Blocks blocks = random_blocks(size, count, static_cast<unsigned>(size + count));
      double expected = 0;
      for (int b = 0; b < count; ++b) {
        const Eigen::MatrixXd block = blocks.dense.block(b * size, b * size, size, size);
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(block);
        expected = std::max(expected, eigen.eigenvalues()[size - 1] / eigen.eigenvalues()[0]);
      }
      EXPECT_NEAR(condition(blocks, size), expected, 1e-9 * expected);
    }
  }
}

TEST(BlockSpectrum, IsThatOfAllBlocks) {
  const Blocks blocks = random_blocks(6, 200, 5);
  ThreadPool pool(2);
  const BlockSpectrum found =
      block_spectrum(blocks.values.data(), 6, 200, blocks.damping.data(), pool);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(blocks.dense);
  const double largest = eigen.eigenvalues()[1199];
  EXPECT_NEAR(found.largest, largest, 1e-12 * largest);
  EXPECT_NEAR(found.smallest, eigen.eigenvalues()[0], 1e-13 * largest);
  const BlockSpectrum bare = block_spectrum(blocks.values.data(), 6, 200, nullptr, pool);
  EXPECT_LT(bare.smallest, found.smallest) << "without the damping";
}

TEST(Condition, DoesNotDependOnTheThreads) {
  const Blocks blocks = random_blocks(3, 1000, 7);
  EXPECT_EQ(condition(blocks, 3, 1), condition(blocks, 3, 4));
}

TEST(Condition, UnknownsWithoutInformationAreLeftOut) {
  const Blocks whole = random_blocks(3, 1, 9);
  Blocks blocks = whole;
  blocks.values.insert(blocks.values.end(), 9, 0.0);  // a point nobody sees
  blocks.damping.insert(blocks.damping.end(), 3, 1e-12);
  EXPECT_EQ(condition(blocks, 3), condition(whole, 3));
  Blocks partly = whole;  // one coordinate held
  for (const std::size_t k : {1U, 3U, 4U, 5U, 7U}) partly.values[k] = 0;
  const double a = whole.values[0] + whole.damping[0], c = whole.values[8] + whole.damping[2];
  const double b = whole.values[2];
  const double root = std::sqrt(0.25 * (a - c) * (a - c) + b * b);
  const double expected = (0.5 * (a + c) + root) / (0.5 * (a + c) - root);
  EXPECT_NEAR(condition(partly, 3), expected, 1e-9 * expected);
}

TEST(BlockSpectrum, OfNothing) {
  ThreadPool pool(1);
  const BlockSpectrum none = block_spectrum(nullptr, 3, 0, nullptr, pool);
  EXPECT_EQ(none.smallest, 0);
  EXPECT_EQ(none.largest, 0);
}

TEST(Condition, SaysSoWhenThereIsNone) {
  Blocks blocks = random_blocks(3, 2, 11);
  blocks.damping.assign(6, 0.0);
  for (std::size_t k = 0; k < 9; ++k) blocks.values[k] = 1;  // rank 1
  EXPECT_GT(condition(blocks, 3), 1e15);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Blocks broken = random_blocks(3, 2, 11);
    broken.values[4] = bad;  // on the diagonal
    EXPECT_EQ(condition(broken, 3), std::numeric_limits<double>::infinity());
    broken = random_blocks(3, 2, 11);
    broken.values[1] = broken.values[3] = bad;
    EXPECT_EQ(condition(broken, 3), std::numeric_limits<double>::infinity());
  }
  EXPECT_EQ(condition({}, 3), 1) << "nothing at all";
}

// The reduced matrix of hubs that a row feels.
Eigen::MatrixXd dense_reduced(const test::BlockSystem& system) {
  const Eigen::MatrixXd H = system.dense.transpose() * system.dense;
  const Eigen::Index hubs = system.layout.size(Side::hubs);
  std::vector<Eigen::Index> felt;
  for (Eigen::Index i = 0; i < hubs; ++i) {
    if (H(i, i) > 0) felt.push_back(i);
  }
  const auto B = H(felt, felt);
  const Eigen::MatrixXd E = H.rightCols(H.cols() - hubs)(felt, Eigen::all);
  const Eigen::MatrixXd C = H.bottomRightCorner(H.rows() - hubs, H.cols() - hubs);
  return B - E * C.completeOrthogonalDecomposition().solve(E.transpose());
}

class ReducedSpectrumOf : public testing::TestWithParam<test::BlockSystemOptions> {};

TEST_P(ReducedSpectrumOf, AgreesWithDenseEigenvalues) {
  test::BlockSystem system(GetParam());
  ThreadPool pool(2);
  ReducedSpectrum spectrum(system.layout, pool);
  const Spectrum found = spectrum.measure(system.linearization(pool));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(dense_reduced(system));
  const double smallest = eigen.eigenvalues()[0];
  const double largest = eigen.eigenvalues()[eigen.eigenvalues().size() - 1];
  ASSERT_GT(smallest, 1e-9 * largest);
  EXPECT_NEAR(found.largest, largest, 1e-8 * largest);
  EXPECT_NEAR(found.smallest, smallest, 1e-6 * smallest);
}

INSTANTIATE_TEST_SUITE_P(
    Systems, ReducedSpectrumOf,
    testing::Values(
        test::BlockSystemOptions{.seed = 1, .leaves = 60},
        test::BlockSystemOptions{.seed = 2, .leaves = 60, .hub_column_spread = 2},
        test::BlockSystemOptions{.seed = 3, .hub_size = 6, .anchored = true, .leaves = 60},
        test::BlockSystemOptions{
            .seed = 4, .row_size = 3, .hub_size = 6, .leaves = 150, .unobserved_leaves = 2},
        test::BlockSystemOptions{.seed = 5, .hubs = 8, .leaves = 60, .unobserved_hubs = 2}),
    [](const auto& each) { return test::name(each.param); });

TEST(ReducedSpectrum, ASingularSystemHasASmallestOfNothing) {
  // Two unknowns of a hub that no row tells apart.
  test::BlockSystem system({.seed = 6, .leaves = 60});
  for (std::int64_t row = 0; row < system.layout.rows; ++row) {
    for (int r = 0; r < 2; ++r) {
      system.J.set(Side::hubs, row, r, 1, system.J.at(Side::hubs, row, r, 0));
    }
  }
  system.update_dense();
  ThreadPool pool(1);
  ReducedSpectrum spectrum(system.layout, pool);
  const Spectrum found = spectrum.measure(system.linearization(pool));
  EXPECT_LT(found.smallest, 1e-13 * found.largest);
  EXPECT_GE(found.smallest, 0);
}

TEST(ReducedSpectrum, SaysWhenALinearisationIsNotFinite) {
  test::BlockSystem system({.seed = 7, .leaves = 60});
  system.J.set(Side::leaves, 0, 1, 1, std::numeric_limits<double>::quiet_NaN());
  ThreadPool pool(1);
  ReducedSpectrum spectrum(system.layout, pool);
  const Spectrum found = spectrum.measure(system.linearization(pool));
  EXPECT_TRUE(std::isnan(found.smallest) && std::isnan(found.largest));
}

}  // namespace
}  // namespace raybundle::linalg
