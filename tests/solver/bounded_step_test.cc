// Steps within a trust region: of inm, dinm and the adaptive method.

#include <raybundle/solver/step.h>

#include <algorithm>
#include <array>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <raybundle/tests/support/dense_objective.h>
#include <raybundle/tests/support/dense_step.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

using Eigen::VectorXd;
using test::DenseObjective;
using test::DenseStep;
using test::StepFixture;

Problem problem_to_step() { return test::small_problem({.seed = 3, .points = 25}); }

constexpr std::array eliminations = {Elimination::none, Elimination::points, Elimination::cameras};
constexpr std::array diagonals = {DiagonalMatrix::identity, DiagonalMatrix::inc,
                                  DiagonalMatrix::diag_h};

// D of |D p| over the unknowns that are solved for.
VectorXd scaled(const DenseObjective& at, const DenseStep& dense, DiagonalMatrix scaling,
                Elimination elimination, const VectorXd& p) {
  VectorXd d = VectorXd::Ones(p.size());
  if (scaling == DiagonalMatrix::diag_h) d = dense.diagonal.cwiseMax(min_diagonal).cwiseSqrt();
  if (scaling == DiagonalMatrix::inc) {
    d = DenseStep::inc_matrix(at.hubs(), at.hub_size(), p.size()).cwiseSqrt();
  }
  VectorXd whole = d.cwiseProduct(p);
  const Eigen::Index hubs = at.hubs() * at.hub_size();
  if (elimination == Elimination::points) return whole.head(hubs);
  if (elimination == Elimination::cameras) return whole.tail(p.size() - hubs);
  return whole;
}

TEST(BoundedStep, StaysWithinTheScaledRegionAndDescends) {
  const Problem problem = problem_to_step();
  DenseObjective at(problem, PoseUpdate::local, Lens::free);
  const DenseStep dense(at, DiagonalMatrix::identity, 1e-2);
  for (const Elimination elimination : eliminations) {
    for (const DiagonalMatrix scaling : diagonals) {
      for (const Preconditioner preconditioner : {Preconditioner::identity, Preconditioner::b}) {
        StepFixture fixture(at, {.method = Method::dinm,
                                 .elimination = elimination,
                                 .preconditioner = preconditioner,
                                 .scaling = scaling});
        const auto free = fixture.solve(dense.damping);
        ASSERT_TRUE(free.report.solved);
        EXPECT_FALSE(free.report.on_boundary);
        const double length = scaled(at, dense, scaling, elimination, free.step).norm();
        EXPECT_NEAR(free.report.length, length, 1e-9 * length);
        double previous = 0;
        for (const double share : {0.01, 0.1, 0.5}) {
          const auto cut = fixture.solve(dense.damping, share * length);
          ASSERT_TRUE(cut.report.solved);
          EXPECT_TRUE(cut.report.on_boundary);
          EXPECT_NEAR(scaled(at, dense, scaling, elimination, cut.step).norm(), share * length,
                      1e-9 * length);
          EXPECT_GT(dense.decrease(cut.step), previous) << "a larger region allows more";
          previous = dense.decrease(cut.step);
        }
        EXPECT_LE(previous, dense.decrease(dense.step()) * (1 + 1e-9));
      }
    }
  }
}

// The gauge leaves seven directions without curvature, and inm has no damping to fill them.
TEST(BoundedStep, NeedsNoDamping) {
  const Problem problem = problem_to_step();
  DenseObjective at(problem, PoseUpdate::local, Lens::free);
  const DenseStep undamped(at, DiagonalMatrix::identity, 0);
  for (const Elimination elimination : eliminations) {
    StepFixture fixture(at, {.method = Method::inm, .elimination = elimination});
    const auto result = fixture.solve(undamped.damping, 1.0);
    ASSERT_TRUE(result.report.solved);
    EXPECT_TRUE(result.step.allFinite());
    EXPECT_GT(undamped.decrease(result.step), 0);
  }
}

// A point whose rays are parallel: its block is singular along them, and without damping its step
// is whatever rounding makes of that, however small the region of the cameras is.
TEST(BoundedStep, HoldsEliminatedBlocksThatNothingDamps) {
  const Problem problem = test::small_problem({.seed = 4, .points = 25, .far_points = 1});
  DenseObjective at(problem, PoseUpdate::local, Lens::free);
  const DenseStep undamped(at, DiagonalMatrix::identity, 0);
  for (const Elimination elimination : {Elimination::points, Elimination::cameras}) {
    StepFixture fixture(
        at,
        {.method = Method::inm, .elimination = elimination, .scaling = DiagonalMatrix::identity});
    const bool points = elimination == Elimination::points;
    const Eigen::Index hubs = at.hubs() * at.hub_size();
    const Eigen::Index first = points ? hubs : 0;
    const Eigen::Index count = points ? undamped.gradient.size() - hubs : hubs;
    double previous = std::numeric_limits<double>::infinity();
    for (const double radius : {1e-2, 1e-4, 1e-6}) {
      const auto result = fixture.solve(undamped.damping, radius, radius);
      ASSERT_TRUE(result.report.solved);
      EXPECT_GT(undamped.decrease(result.step), 0) << "still a descent of the undamped model";
      const double longest = result.step.segment(first, count).cwiseAbs().maxCoeff();
      EXPECT_LE(longest, 3 * radius);
      EXPECT_LT(longest, previous);
      double length = 0;
      const Eigen::Index size = points ? 3 : at.hub_size();
      for (Eigen::Index b = first; b < first + count; b += size) {
        length = std::max(length, result.step.segment(b, size).norm());
      }
      EXPECT_NEAR(result.report.block_length, length, 1e-12 * length);
      EXPECT_EQ(result.report.block_on_boundary, result.report.block_length > 0.5 * radius);
      previous = longest;
    }
  }
}

double worst_block(const Eigen::MatrixXd& H, Eigen::Index first, Eigen::Index size,
                   Eigen::Index count) {
  double worst = 1;
  for (Eigen::Index b = 0; b < count; ++b) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
        H.block(first + b * size, first + b * size, size, size));
    worst = std::max(worst, eigen.eigenvalues()[size - 1] / eigen.eigenvalues()[0]);
  }
  return worst;
}

TEST(AdaptiveStep, EliminatesTheBetterConditionedSide) {
  const Problem problem = problem_to_step();
  DenseObjective at(problem, PoseUpdate::local, Lens::free);
  StepFixture adaptive(at, {.method = Method::adinm});
  bool points_went = false, cameras_went = false;
  for (const double mu : {1e-6, 1.0, 1e3, 1e6, 1e9}) {
    DenseStep dense(at, DiagonalMatrix::identity, mu);
    // Points that are poorly determined, at the price of an unusual damping.
    const Eigen::Index hubs = at.hubs() * at.hub_size();
    dense.damping.tail(dense.damping.size() - hubs).setConstant(1e-3);
    const auto result = adaptive.solve(dense.damping);
    ASSERT_TRUE(result.report.solved);
    Eigen::MatrixXd H = dense.H;
    H.diagonal() += dense.damping;
    const double B = worst_block(H, 0, at.hub_size(), at.hubs());
    const double C = worst_block(H, hubs, 3, (H.rows() - hubs) / 3);
    EXPECT_NEAR(result.report.condition_cameras, B, 1e-6 * B);
    EXPECT_NEAR(result.report.condition_points, C, 1e-6 * C);
    const bool points = C < B;
    EXPECT_EQ(result.report.eliminated, points ? Elimination::points : Elimination::cameras);
    StepFixture fixed(at, {.method = Method::dinm,
                           .elimination = points ? Elimination::points : Elimination::cameras});
    EXPECT_TRUE(result.step == fixed.solve(dense.damping).step) << "that method's own step";
    (points ? points_went : cameras_went) = true;
  }
  EXPECT_TRUE(points_went && cameras_went) << "the test must see both";
}

// [Qu18, Alg. 10, line 18]: Delta_p = Delta_c 3m / 9n.
TEST(AdaptiveStep, RescalesTheRadiusToTheOtherSide) {
  const Problem problem = problem_to_step();
  DenseObjective at(problem, PoseUpdate::local, Lens::free);
  DenseStep dense(at, DiagonalMatrix::identity, 1e9);
  const Eigen::Index hubs = at.hubs() * at.hub_size();
  dense.damping.tail(dense.damping.size() - hubs).setConstant(1e-3);
  StepFixture adaptive(at, {.method = Method::adinm});
  const auto free = adaptive.solve(dense.damping);
  ASSERT_EQ(free.report.eliminated, Elimination::cameras);
  const double radius = 0.1 * free.report.length;
  const auto cut = adaptive.solve(dense.damping, radius);
  ASSERT_TRUE(cut.report.on_boundary);
  EXPECT_NEAR(cut.report.length, radius, 1e-9 * radius);
  const double ratio = static_cast<double>(problem.points.size()) / static_cast<double>(hubs);
  const VectorXd points = cut.step.tail(cut.step.size() - hubs);
  EXPECT_NEAR(points.norm(), ratio * radius, 1e-9 * radius);
}

}  // namespace
}  // namespace raybundle
