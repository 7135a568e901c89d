// Eigenvalues on request: those of the linearisation that an iteration ends with.

#include <raybundle/solver/solve.h>

#include <algorithm>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <raybundle/tests/support/dense_objective.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

// Eigenvalues of the point blocks at the problem's state, from dense matrices.
struct PointEigenvalues {
  double smallest = 1e300, largest = 0;
  explicit PointEigenvalues(const Eigen::MatrixXd& H, Eigen::Index points) {
    for (Eigen::Index at = H.rows() - 3 * points; at < H.rows(); at += 3) {
      const Eigen::Matrix3d block = H.block<3, 3>(at, at);
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(block);
      smallest = std::min(smallest, eigen.eigenvalues()[0]);
      largest = std::max(largest, eigen.eigenvalues()[2]);
    }
  }
};

TEST(Diagnosis, IsOfTheStartAndOfEveryAcceptedStep) {
  for (const PointModel points : {PointModel::xyz, PointModel::pmba}) {
    Problem problem = test::small_problem({.seed = 4, .points = 25});
    const Options options = {
        .points = points, .gauge = Gauge::fixed, .max_iterations = 6, .diagnose = true};
    test::DenseObjective dense(problem, formulation(resolve(options)));
    const Eigen::MatrixXd J = dense.jacobian();
    const PointEigenvalues expected(J.transpose() * J, problem.point_count());
    const Summary summary = solve(problem, options);
    for (const IterationRecord& record : summary.iterations) {
      ASSERT_EQ(record.diagnosis.has_value(), record.accepted);
      if (!record.diagnosis) continue;
      EXPECT_GT(record.diagnosis->reduced_smallest, 0);
      EXPECT_GT(record.diagnosis->reduced_largest, record.diagnosis->reduced_smallest);
      EXPECT_GE(record.diagnosis->points_largest / record.diagnosis->points_smallest,
                record.diagnosis->points_worst_condition * (1 - 1e-12));
    }
    const Diagnosis& start = *summary.iterations.front().diagnosis;
    EXPECT_NEAR(start.points_largest, expected.largest, 1e-9 * expected.largest);
    EXPECT_NEAR(start.points_smallest, expected.smallest, 1e-12 * expected.largest);
  }
}

TEST(Diagnosis, ChangesNothingElse) {
  Problem with = test::small_problem({.seed = 4, .points = 25});
  Problem without = with;
  const Summary a = solve(with, {.max_iterations = 6, .diagnose = true});
  const Summary b = solve(without, {.max_iterations = 6, .precision = Precision::double_precision});
  EXPECT_EQ(a.options.precision, Precision::double_precision) << "eigenvalues want it";
  EXPECT_EQ(with.points, without.points);
  EXPECT_EQ(a.final_cost, b.final_cost);
  EXPECT_FALSE(b.iterations.front().diagnosis);
}

}  // namespace
}  // namespace raybundle
