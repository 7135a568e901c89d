// Steps of every method against the dense damped system.

#include <raybundle/solver/step.h>

#include <array>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <raybundle/solver/option_table.h>
#include <raybundle/tests/support/dense_objective.h>
#include <raybundle/tests/support/dense_step.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::DenseObjective;
using test::DenseStep;
using test::StepFixture;

constexpr std::array diagonals = {DiagonalMatrix::identity, DiagonalMatrix::inc,
                                  DiagonalMatrix::diag_h, DiagonalMatrix::held_h};
constexpr std::array eliminations = {Elimination::none, Elimination::points, Elimination::cameras};

std::vector<Problem> problems() {
  return {test::small_problem({.seed = 1, .points = 25}),
          test::small_problem({.seed = 2,
                               .cameras = 6,
                               .points = 25,
                               .duplicate_observations = 3,
                               .unobserved_cameras = 1,
                               .unobserved_points = 2,
                               .points_seen_once = 2,
                               .far_points = 1,
                               .shuffled = true})};
}

using Variant = std::tuple<Elimination, DiagonalMatrix, DiagonalMatrix>;  // damping, scaling

class StepOf : public ::testing::TestWithParam<Variant> {
 protected:
  Elimination elimination() const { return std::get<0>(GetParam()); }
  DiagonalMatrix damping() const { return std::get<1>(GetParam()); }
  DiagonalMatrix scaling() const { return std::get<2>(GetParam()); }
};

TEST(CholeskyStep, IsTheDenseSolution) {
  for (const Problem& problem : problems()) {
    for (const Lens lens : {Lens::free, Lens::fixed}) {
      DenseObjective at(problem, PoseUpdate::local, lens);
      for (const DiagonalMatrix damping : diagonals) {
        const DenseStep dense(at, damping, 1e-2);
        const VectorXd expected = dense.step();
        for (const Elimination elimination : eliminations) {
          for (const Linear linear :
               {Linear::dense_cholesky, Linear::sparse_cholesky, Linear::cholmod}) {
            StepFixture fixture(at, {.elimination = elimination, .linear = linear});
            const auto result = fixture.solve(dense.damping);
            ASSERT_TRUE(result.report.solved);
            EXPECT_EQ(result.report.inner_iterations, 0);
            EXPECT_LE(dense.distance(result.step, expected), 1e-8 * dense.length(expected));
            EXPECT_EQ(fixture.solver().linear(), linear);
            EXPECT_FALSE(fixture.solver().description().empty());
          }
        }
      }
    }
  }
}

TEST_P(StepOf, ConvergedPcgIsTheDenseSolution) {
  for (const Problem& problem : problems()) {
    DenseObjective at(problem, PoseUpdate::local, Lens::fixed);
    const DenseStep dense(at, damping(), damping() >= DiagonalMatrix::diag_h ? 1e-2 : 1.0);
    const VectorXd expected = dense.step();
    for (int k = 0; k < enum_count<Preconditioner>; ++k) {
      const auto preconditioner = static_cast<Preconditioner>(k);
      if (elimination() == Elimination::none && k > 2) continue;     // there is no S
      if (elimination() == Elimination::cameras && k > 4) continue;  // nor clusters of cameras
      StepFixture fixture(at, {.method = Method::tnm,
                               .elimination = elimination(),
                               .preconditioner = preconditioner,
                               .scaling = scaling(),
                               .max_inner_iterations = 20000,
                               .forcing_rule = ForcingRule::thesis,
                               .forcing = 1e-12});
      const auto result = fixture.solve(dense.damping);
      ASSERT_TRUE(result.report.solved);
      EXPECT_GT(result.report.inner_iterations, 0);
      EXPECT_LE(dense.distance(result.step, expected), 1e-6 * dense.length(expected))
          << name(preconditioner) << " after " << result.report.inner_iterations;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Variants, StepOf,
                         ::testing::Combine(::testing::ValuesIn(eliminations),
                                            ::testing::ValuesIn(diagonals),
                                            ::testing::ValuesIn(diagonals)),
                         [](const auto& variant) {
                           return std::string(name(std::get<0>(variant.param))) + "Damp" +
                                  test::letter(std::get<1>(variant.param)) + "Scale" +
                                  test::letter(std::get<2>(variant.param));
                         });

// |r| <= min(t, |b|) |b| in the scaled unknowns, and not much less [Qu18, Alg. 1].
TEST(PcgStep, ForcingBoundsTheResidualOfTheReducedSystem) {
  DenseObjective at(problems()[0], PoseUpdate::local, Lens::fixed);
  const DenseStep dense(at, DiagonalMatrix::diag_h, 1e-3);
  int previous = 0;
  for (const double forcing : {0.5, 0.1, 1e-2, 1e-4}) {
    for (const DiagonalMatrix scaling : {DiagonalMatrix::identity, DiagonalMatrix::diag_h}) {
      StepFixture fixture(at, {.method = Method::tnm,
                               .elimination = Elimination::none,
                               .scaling = scaling,
                               .forcing_rule = ForcingRule::thesis,
                               .forcing = forcing});
      const auto result = fixture.solve(dense.damping);
      VectorXd inverse = VectorXd::Ones(dense.diagonal.size());
      if (scaling == DiagonalMatrix::diag_h) {
        inverse = dense.diagonal.cwiseMax(min_diagonal).cwiseSqrt().cwiseInverse();
      }
      const VectorXd b = -inverse.cwiseProduct(dense.gradient);
      const VectorXd r = inverse.cwiseProduct(dense.H_damped * result.step) - b;
      EXPECT_LE(r.norm(), forcing * b.norm() * (1 + 1e-9));
      if (scaling == DiagonalMatrix::diag_h) {
        EXPECT_GE(result.report.inner_iterations, previous) << forcing;
        previous = result.report.inner_iterations;
      }
    }
  }
  EXPECT_GT(previous, 0);
}

TEST(PcgStep, KeepsToTheIterationCap) {
  DenseObjective at(problems()[0], PoseUpdate::local, Lens::free);
  const DenseStep dense(at, DiagonalMatrix::diag_h, 1e-6);
  StepFixture fixture(at, {.method = Method::tnm,
                           .max_inner_iterations = 3,
                           .forcing_rule = ForcingRule::thesis,
                           .forcing = 1e-12});
  const auto result = fixture.solve(dense.damping);
  EXPECT_EQ(result.report.inner_iterations, 3);
  EXPECT_GT(dense.decrease(result.step), 0) << "a truncated step is still a descent";
}

TEST(CholeskyStep, SaysWhenTheMatrixCannotBeFactorised) {
  // Without damping the seven freedoms of the gauge leave the matrix singular; minus something it
  // is indefinite for certain.
  DenseObjective at(problems()[0], PoseUpdate::local, Lens::free);
  const DenseStep dense(at, DiagonalMatrix::diag_h, -0.5);
  for (const Linear linear : {Linear::dense_cholesky, Linear::sparse_cholesky, Linear::cholmod}) {
    for (const Elimination elimination : eliminations) {
      StepFixture fixture(at, {.elimination = elimination, .linear = linear});
      EXPECT_FALSE(fixture.solve(dense.damping).report.solved) << name(elimination);
      const DenseStep good(at, DiagonalMatrix::diag_h, 1e-2);
      EXPECT_TRUE(fixture.solve(good.damping).report.solved) << "and recovers";
    }
  }
}

TEST(Step, NothingMovesWhatHasNoInformation) {
  Problem problem = problems()[1];
  problem.fixed_camera_parameters.assign(6, 0);
  problem.fixed_camera_parameters[0] = 0b000'111'111;
  problem.fixed_camera_parameters[1] = 0b110'000'000;
  problem.fixed_points.assign(25, 0);
  problem.fixed_points[7] = 1;
  DenseObjective at(problem, PoseUpdate::local, Lens::free);
  const DenseStep dense(at, DiagonalMatrix::diag_h, 1e-3);
  for (const Method method : {Method::lm_cholesky, Method::tnm}) {
    for (const Elimination elimination : eliminations) {
      StepFixture fixture(at, {.method = method, .elimination = elimination});
      const auto result = fixture.solve(dense.damping);
      ASSERT_TRUE(result.report.solved);
      EXPECT_TRUE(result.step.head(6).isZero(0)) << "fixed pose";
      EXPECT_TRUE(result.step.segment(9 + 7, 2).isZero(0)) << "fixed distortion";
      EXPECT_TRUE(result.step.segment(5 * 9, 9).isZero(0)) << "camera without observations";
      EXPECT_TRUE(result.step.segment(6 * 9 + 3 * 7, 3).isZero(0)) << "fixed point";
      EXPECT_TRUE(result.step.tail(6).isZero(0)) << "points nobody sees";
    }
  }
}

// A camera with f of 1e9 far from everything, as BAL files hold: steps stay accurate in the units
// of each unknown.
TEST(Step, HugeFocalLengthsCostNoAccuracy) {
  Problem problem = problems()[0];
  // The same picture from a million times farther away.
  constexpr double zoom = 1e6;
  const double distance = std::abs(problem.cameras[5]);
  problem.cameras[5] -= (zoom - 1) * distance;
  problem.cameras[6] *= zoom;
  problem.cameras[7] *= zoom * zoom;
  problem.cameras[8] = 0;
  DenseObjective at(problem, PoseUpdate::local, Lens::free);
  ASSERT_LT(at.cost(), 1e6) << "the picture is roughly the same";
  const DenseStep dense(at, DiagonalMatrix::diag_h, 1e-3);
  const VectorXd expected = dense.step();
  for (const Elimination elimination : eliminations) {
    for (const Linear linear : {Linear::dense_cholesky, Linear::sparse_cholesky, Linear::cholmod}) {
      StepFixture fixture(at, {.elimination = elimination, .linear = linear});
      const auto result = fixture.solve(dense.damping);
      ASSERT_TRUE(result.report.solved);
      EXPECT_LE(dense.distance(result.step, expected), 1e-7 * dense.length(expected));
    }
  }
}

}  // namespace
}  // namespace raybundle
