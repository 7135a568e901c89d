// Eigenvalues of the reduced system against dense ones.

#include <raybundle/linalg/spectrum.h>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <raybundle/tests/support/block_system.h>

namespace raybundle::linalg {
namespace {

// The reduced matrix of hubs that a row feels.
Eigen::MatrixXd dense_reduced(const test::BlockSystem& system) {
  const Eigen::MatrixXd H = system.dense.transpose() * system.dense;
  const Eigen::Index hubs = system.layout.size(Side::hubs), leaves = H.cols() - hubs;
  const Eigen::MatrixXd C = H.bottomRightCorner(leaves, leaves);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(C);
  const double least = 1e-12 * eigen.eigenvalues()[leaves - 1];
  Eigen::MatrixXd F = H.topRightCorner(hubs, leaves) * eigen.eigenvectors();
  for (Eigen::Index i = 0; i < leaves; ++i) {
    const double value = eigen.eigenvalues()[i];
    F.col(i) *= value > least ? 1 / std::sqrt(value) : 0;
  }
  Eigen::MatrixXd S = H.topLeftCorner(hubs, hubs);
  S -= F * F.transpose();
  Eigen::Index felt = 0;
  for (Eigen::Index i = 0; i < hubs; ++i) {
    if (H(i, i) == 0) continue;
    S.row(felt) = S.row(i);
    S.col(felt++) = S.col(i);
  }
  return S.topLeftCorner(felt, felt);
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
