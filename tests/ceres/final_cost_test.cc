// Ceres as an oracle: the same problem, the same cost function, the same minimum.

#include <cstdint>

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <raybundle/models/problem.h>
#include <raybundle/solver/solve.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

// The BAL camera, spelled out for automatic differentiation.
struct Reprojection {
  double x, y;

  template <class T>
  bool operator()(const T* camera, const T* point, T* residual) const {
    T X_c[3];
    ceres::AngleAxisRotatePoint(camera, point, X_c);
    for (int i = 0; i < 3; ++i) X_c[i] += camera[3 + i];
    const T px = -X_c[0] / X_c[2];
    const T py = -X_c[1] / X_c[2];
    const T n = px * px + py * py;
    const T scale = camera[6] * (1.0 + n * (camera[7] + n * camera[8]));
    residual[0] = scale * px - x;
    residual[1] = scale * py - y;
    return true;
  }
};

ceres::Solver::Summary solve_with_ceres(Problem& problem) {
  ceres::Problem model;
  for (std::size_t k = 0; k < problem.observation_camera.size(); ++k) {
    auto* cost = new ceres::AutoDiffCostFunction<Reprojection, 2, 9, 3>(
        new Reprojection{problem.observations[2 * k], problem.observations[2 * k + 1]});
    model.AddResidualBlock(
        cost, nullptr,
        &problem.cameras[9 * static_cast<std::size_t>(problem.observation_camera[k])],
        &problem.points[3 * static_cast<std::size_t>(problem.observation_point[k])]);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 300;
  options.function_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &model, &summary);
  return summary;
}

class AgainstCeres : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  Problem problem() const {
    return test::small_problem({.seed = GetParam(),
                                .cameras = 7,
                                .points = 60,
                                .observations_per_point = 4,
                                .duplicate_observations = 4,
                                .shuffled = true});
  }
};

TEST_P(AgainstCeres, StartAndFinalCostAgree) {
  Problem theirs = problem();
  const ceres::Solver::Summary ceres = solve_with_ceres(theirs);
  ASSERT_TRUE(ceres.IsSolutionUsable());
  for (const Method method : {Method::lm_cholesky, Method::tnm}) {
    for (const PoseUpdate update : {PoseUpdate::global, PoseUpdate::local, PoseUpdate::se3}) {
      Problem ours = problem();
      const Summary summary = solve(ours, {.method = method,
                                           .pose_update = update,
                                           .max_iterations = 300,
                                           .function_tolerance = 1e-12});
      EXPECT_NEAR(summary.initial_cost, ceres.initial_cost, 1e-10 * ceres.initial_cost);
      EXPECT_NEAR(summary.final_cost, ceres.final_cost, 1e-6 * ceres.final_cost)
          << name(method) << ", " << name(update) << ", " << summary.message;
    }
  }
}

// Neither finds anything to improve in what the other found.
TEST_P(AgainstCeres, OurMinimumIsTheirs) {
  Problem ours = problem();
  const Summary summary = solve(ours, {.max_iterations = 300, .function_tolerance = 1e-14});
  const ceres::Solver::Summary ceres = solve_with_ceres(ours);
  EXPECT_NEAR(ceres.initial_cost, summary.final_cost, 1e-10 * summary.final_cost);
  EXPECT_GE(ceres.final_cost, (1 - 1e-8) * summary.final_cost);
}

INSTANTIATE_TEST_SUITE_P(Seeds, AgainstCeres, ::testing::Values(1, 2, 3, 4, 5));

}  // namespace
}  // namespace raybundle
