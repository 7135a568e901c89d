// The Objective with a loss: its cost, and derivatives that belong to it.

#include <raybundle/models/objective.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <raybundle/models/error.h>
#include <raybundle/tests/support/dense_objective.h>
#include <raybundle/tests/support/random_problem.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::DenseObjective;
using test::small_problem;

const std::vector<Loss> losses = {Loss::huber,         Loss::soft_l1, Loss::cauchy,
                                  Loss::geman_mcclure, Loss::tukey,   Loss::truncated};

/// Residuals of a few pixels, some rows far off, pairs observed twice, unobserved blocks.
Problem problem_with_outliers(std::uint64_t seed, int points = 40) {
  Problem problem = small_problem({.seed = seed,
                                   .cameras = 5,
                                   .points = points,
                                   .duplicate_observations = 3,
                                   .unobserved_cameras = 1,
                                   .unobserved_points = 1,
                                   .shuffled = true});
  for (std::size_t k = 0; k < problem.observations.size(); k += 13) problem.observations[k] += 300;
  return problem;
}

using Variant = std::tuple<PoseUpdate, LossScope>;

class RobustObjective : public ::testing::TestWithParam<Variant> {
 protected:
  PoseUpdate update() const { return std::get<0>(GetParam()); }
  RobustLoss loss(Loss kind, double scale = 3) const {
    return {kind, std::get<1>(GetParam()), scale};
  }
};

TEST_P(RobustObjective, CostIsHalfTheSumOfRho) {
  const Problem problem = problem_with_outliers(1, 300);
  DenseObjective plain(problem, update(), Lens::free);
  const VectorXd& r = plain.residual();
  for (const Loss kind : losses) {
    DenseObjective robust(problem, update(), Lens::free, 2, loss(kind));
    double expected = 0;
    for (Eigen::Index i = 0; i < r.size(); i += 2) {
      const double x = r[i] * r[i], y = r[i + 1] * r[i + 1];
      expected += loss(kind).scope == LossScope::observation
                      ? evaluate(loss(kind), x + y).rho
                      : evaluate(loss(kind), x).rho + evaluate(loss(kind), y).rho;
    }
    EXPECT_NEAR(robust.cost(), expected / 2, 1e-13 * expected);
    EXPECT_NEAR(robust.objective().cost(robust.state()), expected / 2, 1e-13 * expected);
    EXPECT_LT(robust.cost(), 0.5 * plain.cost());  // the outliers weigh less
  }
}

TEST_P(RobustObjective, GradientIsThatOfTheCost) {
  const Problem problem = problem_with_outliers(2);
  for (const Lens lens : {Lens::free, Lens::fixed}) {
    for (const Loss kind : losses) {
      DenseObjective robust(problem, update(), lens, 2, loss(kind));
      const VectorXd gradient = robust.jacobian().transpose() * robust.residual();
      std::mt19937_64 random(7);
      for (int trial = 0; trial < 5; ++trial) {
        VectorXd d(gradient.size());
        for (double& x : d) x = test::uniform(random);
        constexpr double h = 1e-6;
        const double slope = (robust.cost_after(h * d) - robust.cost_after(-h * d)) / (2 * h);
        EXPECT_NEAR(gradient.dot(d), slope, 1e-7 * gradient.norm() * d.norm())
            << "loss " << static_cast<int>(kind);
      }
    }
  }
}

// J^T J = J_0^T W J_0 with the weights of the plain residuals  [Qu18, Eq. 4.23, 4.26].
TEST_P(RobustObjective, MatrixIsTheReweightedOne) {
  const Problem problem = problem_with_outliers(3);
  DenseObjective plain(problem, update(), Lens::free);
  for (const Loss kind : losses) {
    DenseObjective robust(problem, update(), Lens::free, 2, loss(kind));
    VectorXd w(plain.residual().size());
    for (Eigen::Index i = 0; i < w.size(); ++i) {
      const Eigen::Index first = i / 2 * 2;
      const double s = loss(kind).scope == LossScope::observation
                           ? plain.residual().segment(first, 2).squaredNorm()
                           : plain.residual()[i] * plain.residual()[i];
      w[i] = evaluate(loss(kind), s).weight;
    }
    const MatrixXd expected = plain.jacobian().transpose() * w.asDiagonal() * plain.jacobian();
    const MatrixXd J = robust.jacobian();
    EXPECT_LE((J.transpose() * J - expected).norm(), 1e-12 * expected.norm());
  }
}

// The weighted squares, moved to touch the cost here, lie above it everywhere.
TEST_P(RobustObjective, WeightedSquaresMajoriseTheCost) {
  const Problem problem = problem_with_outliers(4);
  DenseObjective plain(problem, update(), Lens::free);
  for (const Loss kind : losses) {
    DenseObjective robust(problem, update(), Lens::free, 2, loss(kind));
    std::vector<double> root(static_cast<std::size_t>(plain.residual().size()));
    robust_weights(loss(kind), plain.residual().data(), plain.residual().size() / 2, 2,
                   root.data());
    const Eigen::Map<const VectorXd> factor(root.data(), plain.residual().size());
    std::mt19937_64 random(11);
    for (const double size : {1e-4, 1e-3, 1e-2, 0.1}) {
      VectorXd d(plain.objective().layout().unknowns());
      for (double& x : d) x = size * test::uniform(random);
      const double bound = robust.cost() +
                           0.5 * factor.cwiseProduct(plain.residual_after(d)).squaredNorm() -
                           0.5 * robust.residual().squaredNorm();
      EXPECT_LE(robust.cost_after(d), bound + 1e-12 * std::abs(bound));
    }
  }
}

TEST_P(RobustObjective, ScaleCanChange) {
  const Problem problem = problem_with_outliers(5);
  for (const Loss kind : losses) {
    DenseObjective changed(problem, update(), Lens::free, 2, loss(kind, 50));
    DenseObjective built(problem, update(), Lens::free, 2, loss(kind, 2));
    EXPECT_NE(changed.cost(), built.cost());
    changed.objective().set_loss_scale(2);
    EXPECT_EQ(changed.objective().loss_scale(), 2);
    EXPECT_EQ(changed.objective().cost(changed.state()), built.objective().cost(built.state()));
    EXPECT_TRUE(changed.residual_after(VectorXd::Zero(built.objective().layout().unknowns())) ==
                built.residual_after(VectorXd::Zero(built.objective().layout().unknowns())));
  }
}

TEST_P(RobustObjective, SameBitsForAnyNumberOfThreads) {
  const Problem problem = problem_with_outliers(6, 900);
  for (const Loss kind : losses) {
    DenseObjective one(problem, update(), Lens::free, 1, loss(kind));
    for (const int threads : {2, 3}) {
      DenseObjective many(problem, update(), Lens::free, threads, loss(kind));
      EXPECT_EQ(one.cost(), many.cost());
      EXPECT_EQ(one.objective().cost(one.state()), many.objective().cost(many.state()));
      EXPECT_TRUE(one.residual() == many.residual());
      EXPECT_TRUE(one.same_rows(many));
    }
  }
}

// With the scale above every residual, Huber and truncated do nothing: not even a bit changes in
// the derivatives.
TEST_P(RobustObjective, WideScaleLeavesTheDerivatives) {
  const Problem problem = problem_with_outliers(7);
  DenseObjective plain(problem, update(), Lens::free);
  for (const Loss kind : {Loss::none, Loss::huber, Loss::truncated}) {
    DenseObjective robust(problem, update(), Lens::free, 2, loss(kind, 1e6));
    EXPECT_NEAR(robust.cost(), plain.cost(), 1e-14 * plain.cost());
    EXPECT_TRUE(robust.residual() == plain.residual());
    EXPECT_TRUE(robust.same_rows(plain));
  }
}

std::string name_of(const ::testing::TestParamInfo<Variant>& test) {
  const char* const updates[] = {"Global", "Local", "Se3"};
  const bool whole = std::get<1>(test.param) == LossScope::observation;
  return std::string(updates[static_cast<int>(std::get<0>(test.param))]) +
         (whole ? "Observation" : "Component");
}

INSTANTIATE_TEST_SUITE_P(
    Variants, RobustObjective,
    ::testing::Combine(::testing::Values(PoseUpdate::global, PoseUpdate::local, PoseUpdate::se3),
                       ::testing::Values(LossScope::observation, LossScope::component)),
    name_of);

TEST(RobustObjectiveRows, BeyondTheCutAreZero) {
  const Problem problem = problem_with_outliers(8);
  DenseObjective plain(problem, PoseUpdate::local, Lens::free);
  for (const Loss kind : {Loss::tukey, Loss::truncated}) {
    DenseObjective robust(problem, PoseUpdate::local, Lens::free, 1, {.kind = kind, .scale = 100});
    const MatrixXd J = robust.jacobian();
    int cut = 0;
    for (Eigen::Index i = 0; i < plain.residual().size(); i += 2) {
      const bool beyond = plain.residual().segment(i, 2).norm() > 100;
      cut += beyond ? 1 : 0;
      EXPECT_EQ(J.middleRows(i, 2).isZero(0), beyond);
      EXPECT_EQ(robust.residual().segment(i, 2).isZero(0), beyond);
    }
    EXPECT_GT(cut, 0);
  }
}

/// One camera at the origin that looks at a point so close that its projection is finite and the
/// derivative of that is not; the observation is 1,000 pixels away.
Problem infinite_derivative() {
  Problem problem = small_problem({.seed = 9});
  const auto j = static_cast<std::size_t>(problem.observation_camera[0]);
  const auto i = static_cast<std::size_t>(problem.observation_point[0]);
  // Nobody else sees that point.
  for (std::size_t k = 1; k < problem.observation_point.size(); ++k) {
    if (problem.observation_point[k] == static_cast<std::int32_t>(i))
      ++problem.observation_point[k];
  }
  std::fill_n(problem.cameras.begin() + static_cast<std::ptrdiff_t>(9 * j), 6, 0.0);
  problem.points[3 * i] = problem.points[3 * i + 2] = -1e-307;
  problem.points[3 * i + 1] = 0;
  problem.observations[0] = problem.observations[1] = 1000;
  return problem;
}

TEST(RobustObjectiveRows, BeyondTheCutAreZeroWhateverTheirDerivative) {
  const Problem problem = infinite_derivative();
  DenseObjective plain(problem, PoseUpdate::local, Lens::free);
  ASSERT_TRUE(plain.residual().allFinite());
  ASSERT_FALSE(plain.jacobian().allFinite());
  for (const Loss kind : {Loss::tukey, Loss::truncated}) {
    DenseObjective robust(problem, PoseUpdate::local, Lens::free, 1, {.kind = kind, .scale = 100});
    EXPECT_TRUE(std::isfinite(robust.cost()));
    EXPECT_TRUE(robust.jacobian().allFinite());
  }
}

// No loss may hide what cannot be projected, or a solve would walk there.
TEST(RobustObjectiveRows, WhatCannotBeProjectedIsNotAnOutlier) {
  Problem problem = small_problem({.seed = 5});
  const auto j = static_cast<std::size_t>(problem.observation_camera[0]);
  const auto i = static_cast<std::size_t>(problem.observation_point[0]);
  std::fill_n(problem.cameras.begin() + static_cast<std::ptrdiff_t>(9 * j), 6, 0.0);
  for (const double x : {0.0, 1.0}) {  // 0/0 and 1/0
    problem.points[3 * i] = x;
    problem.points[3 * i + 2] = 0;
    for (const LossScope scope : {LossScope::observation, LossScope::component}) {
      for (const Loss kind : losses) {
        DenseObjective robust(problem, PoseUpdate::local, Lens::free, 1, {kind, scope, 1});
        EXPECT_FALSE(std::isfinite(robust.cost())) << static_cast<int>(kind);
        EXPECT_FALSE(std::isfinite(robust.objective().cost(robust.state())));
        EXPECT_FALSE(robust.residual().allFinite());
      }
    }
  }
}

TEST(RobustObjectiveScale, MustBeLegal) {
  const Problem problem = small_problem({.seed = 1});
  linalg::ThreadPool pool(1);
  const auto build = [&](double scale) {
    Objective objective(problem, {}, pool, {Loss::huber, {}, scale});
    return objective.loss_scale();
  };
  EXPECT_EQ(build(2), 2);
  EXPECT_THROW(build(0), InputError);
  Objective objective(problem, {}, pool, {.kind = Loss::huber});
  EXPECT_THROW(objective.set_loss_scale(-1), InputError);
  EXPECT_EQ(objective.loss_scale(), 1);  // as it was
}

}  // namespace
}  // namespace raybundle
