// Powell's dogleg against its definition on dense matrices, and in the engine.

#include <raybundle/solver/solve.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <raybundle/tests/support/dense_objective.h>
#include <raybundle/tests/support/dense_step.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

using Eigen::VectorXd;
using test::DenseObjective;
using test::DenseStep;
using test::StepFixture;

// Both ends of the path, densely. Unknowns without derivative are left out.
struct Path {
  Path(const DenseObjective& at, DiagonalMatrix scaling) : dense(at, DiagonalMatrix::identity, 0) {
    const VectorXd& g = dense.gradient;
    d = VectorXd::Ones(g.size());
    if (scaling == DiagonalMatrix::diag_h) d = dense.diagonal.cwiseMax(min_diagonal).cwiseSqrt();
    const VectorXd steepest = -g.cwiseQuotient(d).cwiseQuotient(d);
    cauchy = -g.dot(steepest) / steepest.dot(dense.H * steepest) * steepest;
    Eigen::MatrixXd H = dense.H;
    for (Eigen::Index i = 0; i < H.rows(); ++i) {
      if (H(i, i) == 0) H(i, i) = 1;
    }
    const VectorXd unit = H.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = unit.asDiagonal() * H * unit.asDiagonal();
    newton = -unit.cwiseProduct(scaled.ldlt().solve(VectorXd(unit.cwiseProduct(g))));
  }
  double length(const VectorXd& p) const { return p.cwiseProduct(d).norm(); }

  DenseStep dense;
  VectorXd d, cauchy, newton;
};

Formulation formulation_for(PointModel points) {
  return {.lens = Lens::fixed, .points = points, .gauge = Gauge::fixed};
}

class Dogleg : public ::testing::TestWithParam<DiagonalMatrix> {};

TEST_P(Dogleg, FollowsThePath) {
  for (const PointModel points : {PointModel::xyz, PointModel::pmba}) {
    DenseObjective at(test::small_problem({.seed = 3, .points = 25}), formulation_for(points));
    const Path path(at, GetParam());
    StepFixture fixture(
        at,
        {.method = Method::dogleg, .scaling = GetParam(), .lens = Lens::fixed, .points = points});
    const VectorXd nothing = VectorXd::Zero(path.newton.size());
    const auto free = fixture.solve(nothing);
    ASSERT_TRUE(free.report.solved);
    EXPECT_EQ(free.report.linear_solves, 1);
    EXPECT_EQ(free.report.regularisation, 0);
    EXPECT_FALSE(free.report.on_boundary);
    EXPECT_LE((free.step - path.newton).norm(), 1e-8 * path.newton.norm());

    const double shorter = path.length(path.cauchy), longer = path.length(path.newton);
    ASSERT_LT(shorter, longer);
    double previous = 0;
    for (const double radius :
         {0.1 * shorter, shorter, shorter + 0.3 * (longer - shorter), 0.99 * longer}) {
      const auto cut = fixture.solve(nothing, radius, {}, false);
      ASSERT_TRUE(cut.report.solved);
      EXPECT_EQ(cut.report.linear_solves, 0) << "the factorisation serves all retries";
      EXPECT_TRUE(cut.report.on_boundary);
      EXPECT_NEAR(path.length(cut.step), radius, 1e-9 * radius);
      EXPECT_NEAR(cut.report.length, radius, 1e-12 * radius);
      // On the segment: what is left after the Cauchy point is a share of the second leg.
      const VectorXd leg = path.newton - path.cauchy;
      const double t = std::clamp((cut.step - path.cauchy).dot(leg) / leg.squaredNorm(), 0.0, 1.0);
      const VectorXd expected = radius <= shorter ? VectorXd(radius / shorter * path.cauchy)
                                                  : VectorXd(path.cauchy + t * leg);
      EXPECT_LE((cut.step - expected).norm(), 1e-7 * expected.norm());
      EXPECT_GT(path.dense.decrease(cut.step), previous) << "a larger region allows more";
      previous = path.dense.decrease(cut.step);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scaling, Dogleg,
                         ::testing::Values(DiagonalMatrix::identity, DiagonalMatrix::diag_h),
                         [](const auto& test) { return test::letter(test.param); });

// Coordinates of a point whose rays are parallel: H is singular and has to be helped, which counts.
TEST(DoglegSolve, SingularNormalEquationsAreHelpedAndCounted) {
  Problem problem = test::small_problem({.seed = 4, .cameras = 5, .points = 25, .pixel_noise = 0});
  problem.fixed_points.assign(25, 1);  // nothing but poses, and one camera sees nobody
  std::replace(problem.observation_camera.begin(), problem.observation_camera.end(), 4, 3);
  const Summary summary = solve(problem, {.method = Method::dogleg, .max_iterations = 30});
  EXPECT_TRUE(summary.usable()) << summary.message;
  EXPECT_TRUE(std::isfinite(summary.final_cost));
  EXPECT_EQ(summary.regularised, 0) << "what nobody depends on is no singularity";
}

TEST(DoglegSolve, AllPointModelsReachOneMinimum) {
  double expected = 0;
  for (const Method method : {Method::lm_cholesky, Method::dogleg}) {
    for (const PointModel points :
         {PointModel::xyz, PointModel::idp, PointModel::pba, PointModel::pmba}) {
      Problem problem = test::small_problem({.seed = 7, .cameras = 6, .points = 60});
      const Summary summary = solve(problem, {.method = method,
                                              .lens = Lens::fixed,
                                              .points = points,
                                              .max_iterations = 300,
                                              .function_tolerance = 1e-13});
      if (expected == 0) expected = summary.final_cost;
      EXPECT_NEAR(summary.final_cost, expected, 1e-8 * expected)
          << name(method) << ", " << name(points) << ": " << summary.message;
      EXPECT_EQ(outcome(summary.termination), Outcome::converged) << summary.message;
    }
  }
}

TEST(DoglegSolve, RaysEndNearTheMinimumOfPixels) {
  Problem by_pixels = test::small_problem({.seed = 7, .cameras = 6, .points = 60});
  Problem by_rays = by_pixels;
  const Options options = {.method = Method::dogleg,
                           .lens = Lens::fixed,
                           .points = PointModel::pmba,
                           .max_iterations = 300,
                           .function_tolerance = 1e-12};
  const double pixels = solve(by_pixels, options).final_cost;
  Options of_rays = options;
  of_rays.objective = ObjectiveKind::ray;
  const Summary summary = solve(by_rays, of_rays);
  EXPECT_NEAR(summary.iterations.back().pixel_cost, pixels, 1e-4 * pixels);
  EXPECT_NEAR(summary.final_cost, pixels, 1e-2 * pixels);
}

// The step that is judged is the one that is left, and a step that nobody had to be held for is
// that of --point-steps all.
TEST(PointSteps, HeldPointsAreNotPromised) {
  Problem problem = test::small_problem({.seed = 6, .points = 40, .parameter_noise = 0.5});
  bool held = false;
  for (const PointModel points : {PointModel::xyz, PointModel::pmba}) {
    Problem better = problem, all = problem;
    const Options options = {.method = Method::dogleg,
                             .lens = Lens::fixed,
                             .points = points,
                             .max_iterations = 40,
                             .max_consecutive_failures = 40};
    const Summary summary = solve(better, options);
    Options every = options;
    every.point_steps = PointSteps::all;
    const Summary plain = solve(all, every);
    bool same = true;
    for (std::size_t i = 1; i < summary.iterations.size(); ++i) {
      const IterationRecord& record = summary.iterations[i];
      held = held || record.points_held > 0;
      same = same && record.points_held == 0;
      if (same) {
        EXPECT_EQ(record.candidate_cost, plain.iterations.at(i).candidate_cost);
      }
      if (record.accepted) {
        const double gain = summary.iterations[i - 1].cost - record.cost;
        EXPECT_NEAR(record.rho * record.predicted_decrease, gain, 1e-9 * (1 + std::abs(gain)));
      }
    }
    for (const IterationRecord& record : plain.iterations) EXPECT_EQ(record.points_held, 0);
    EXPECT_LE(summary.final_cost, plain.final_cost * (1 + 1e-6));
  }
  EXPECT_TRUE(held);
}

}  // namespace
}  // namespace raybundle
