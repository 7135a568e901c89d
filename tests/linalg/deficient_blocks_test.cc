// Blocks that Cholesky refuses in an elimination: directions without information get no step, and
// everything else is solved in the least squares sense.

#include <raybundle/linalg/schur_complement.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <raybundle/tests/support/block_system.h>

namespace raybundle::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::BlockSystem;

// Gauss-Newton steps (no damping) with leaves of rank 2 and leaves and hubs nobody observes.
class DeficientLeaves : public ::testing::TestWithParam<std::pair<int, bool>> {
 protected:
  DeficientLeaves()
      : system_({.seed = 31,
                 .hub_size = GetParam().first,
                 .anchored = GetParam().second,
                 .hubs = 3,
                 .leaves = 60,
                 .unobserved_leaves = 2,
                 .poor_leaves = 5,
                 .damping = 0}),
        reduced_(system_.layout, Side::leaves, pool_) {
    reduced_.prepare(system_.linearization(pool_), system_.D.data());
    SymmetricBlocks A(reduced_.pattern(), SymmetricBlocks::Storage::dense);
    VectorXd v(reduced_.size());
    reduced_.assemble(A, v.data());
    A_ = test::dense_of(A);
    v_ = v;
    const VectorXd x = -A_.ldlt().solve(v);
    step_.resize(system_.layout.unknowns());
    reduced_.expand(x.data(), step_.data());
  }

  MatrixXd leaf_block(std::int64_t leaf) const {
    const std::int64_t at = system_.layout.offset(Side::leaves) + 3 * leaf;
    return (system_.dense.transpose() * system_.dense).block(at, at, 3, 3);
  }

  // What the rows of a leaf see of its step: anchors that move take it with them.
  VectorXd seen_step(std::int64_t leaf) const {
    const BlockLayout& layout = system_.layout;
    VectorXd p = step_.segment(layout.offset(Side::leaves) + 3 * leaf, 3);
    if (!layout.anchored()) return p;
    const int size = layout.hub_size;
    for (auto k = layout.anchorage.begin[index(leaf)]; k < layout.anchorage.begin[index(leaf + 1)];
         ++k) {
      const auto hub = layout.hub_side.block[index(layout.anchorage.coupling[index(k)])];
      const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> Z(
          system_.J.anchor_blocks.data() + 3 * size * k, 3, size);
      p += Z * step_.segment(hub * size, size);
    }
    return p;
  }

  ThreadPool pool_{2};
  BlockSystem system_;
  SchurComplement reduced_;
  MatrixXd A_;
  VectorXd v_;
  VectorXd step_;
};

TEST_P(DeficientLeaves, AreCounted) { EXPECT_EQ(reduced_.deficient_blocks(), 7); }

TEST_P(DeficientLeaves, StepSolvesTheLeastSquaresProblem) {
  // The normal equations hold in full: nothing that could be explained is left over.
  const VectorXd residual = system_.dense.transpose() * (system_.dense * step_ + system_.r);
  EXPECT_LE(residual.norm(), 1e-10 * system_.gradient().norm());
}

TEST_P(DeficientLeaves, StepHasNoComponentAlongNullDirections) {
  for (std::int64_t leaf = 0; leaf < 5; ++leaf) {
    const MatrixXd C = leaf_block(leaf);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(C);
    ASSERT_LE(eigen.eigenvalues()[0], 1e-14 * eigen.eigenvalues()[2]);
    const VectorXd null = eigen.eigenvectors().col(0);
    const VectorXd p = seen_step(leaf);
    // Orthogonal in the metric of the block's diagonal, which has no units.
    const VectorXd metric = C.diagonal();
    const double along = null.dot(metric.cwiseProduct(p));
    const double lengths =
        std::sqrt(null.dot(metric.cwiseProduct(null))) * std::sqrt(p.dot(metric.cwiseProduct(p)));
    EXPECT_LE(std::abs(along), 1e-9 * lengths);
    EXPECT_GT(p.norm(), 0.0) << "the rest of the leaf does move";
  }
}

TEST_P(DeficientLeaves, UnobservedLeavesStayExactly) { EXPECT_TRUE(step_.tail(6).isZero(0)); }

TEST_P(DeficientLeaves, ImplicitAndExplicitAgree) {
  std::mt19937_64 random(4);
  const VectorXd x = VectorXd::NullaryExpr(reduced_.size(), [&] { return test::uniform(random); });
  VectorXd y(x.size()), v(x.size());
  reduced_.apply(x.data(), y.data());
  reduced_.gradient(v.data());
  EXPECT_LE((y - A_ * x).norm(), 1e-11 * A_.norm() * x.norm());
  EXPECT_LE((v - v_).norm(), 1e-11 * system_.gradient().norm());
}

INSTANTIATE_TEST_SUITE_P(HubSizes, DeficientLeaves,
                         ::testing::Values(std::pair(9, false), std::pair(6, false),
                                           std::pair(9, true), std::pair(6, true)),
                         [](const auto& each) {
                           return "Hub" + std::to_string(each.param.first) +
                                  (each.param.second ? "Anchored" : "");
                         });

// A far point as seen in practice: its block is singular but for rounding. With damping the step is
// the damped solution, however little the block says by itself.
TEST(NearlyDeficientLeaf, DampedStepIsTheDampedSolution) {
  for (const double smallest : {1e-3, 1e-6, 1e-8, 1e-12, 0.0}) {
    BlockSystem system({.seed = 41, .hubs = 3, .leaves = 30});
    // The third column of the first leaf (six residuals): little that the others do not say.
    for (int i = 0; i < 6; ++i) {
      const auto at = [&](int k) { return system.J.at(Side::leaves, i / 2, i % 2, k); };
      system.J.set(Side::leaves, i / 2, i % 2, 2, 0.5 * at(0) - 0.25 * at(1) + smallest * at(2));
    }
    system.update_dense();
    system.D = 1e-6 * system.dense.colwise().squaredNorm();
    const VectorXd expected = -system.H().ldlt().solve(system.gradient());
    ThreadPool pool(1);
    for (const Side side : {Side::leaves, Side::hubs}) {
      SchurComplement reduced(system.layout, side, pool);
      reduced.prepare(system.linearization(pool), system.D.data());
      EXPECT_EQ(reduced.deficient_blocks(), 0) << "damping makes it definite";
      SymmetricBlocks A(reduced.pattern(), SymmetricBlocks::Storage::dense);
      VectorXd v(reduced.size()), step(system.layout.unknowns());
      reduced.assemble(A, v.data());
      const VectorXd x = -test::dense_of(A).ldlt().solve(v);
      reduced.expand(x.data(), step.data());
      EXPECT_LE((step - expected).norm(), 1e-6 * expected.norm()) << smallest;
    }
  }
}

}  // namespace
}  // namespace raybundle::linalg
