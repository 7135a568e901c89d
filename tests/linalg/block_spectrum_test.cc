// Eigenvalues of diagonal blocks against dense ones.

#include <raybundle/linalg/spectrum.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

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

}  // namespace
}  // namespace raybundle::linalg
