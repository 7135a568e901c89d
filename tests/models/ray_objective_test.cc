// What the ray objective refuses, and tells apart where pixels cannot.

#include <raybundle/models/objective.h>

#include <stdexcept>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <raybundle/models/error.h>
#include <raybundle/models/rotation.h>
#include <raybundle/tests/support/dense_objective.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

using Eigen::Vector3d;
using test::DenseObjective;
using test::small_problem;

TEST(RayObjective, RefusesFreeLenses) {
  EXPECT_THROW(DenseObjective(small_problem(), Formulation{.objective = ObjectiveKind::ray}),
               std::invalid_argument);
}

TEST(RayObjective, RefusesWhatTheLensCannotHaveSeen) {
  Problem problem = small_problem();
  problem.cameras[7] = -0.5;  // folds back at |p| = 0.816, where u = 0.544 f
  problem.observation_camera[3] = 0;
  problem.observations[6] = 2000;
  EXPECT_THROW(
      DenseObjective(problem, Formulation{.lens = Lens::fixed, .objective = ObjectiveKind::ray}),
      InputError);
}

TEST(RayObjective, TellsAPointBehindTheCameraFromOneInFront) {
  Problem problem = small_problem({.pixel_noise = 0, .parameter_noise = 0});
  const Formulation ray = {.lens = Lens::fixed, .objective = ObjectiveKind::ray};
  const Formulation pixel = {.lens = Lens::fixed};
  EXPECT_LE(DenseObjective(problem, ray).cost(), 1e-12);
  // Every observer's view of the point, mirrored in its centre, is seen from two cameras only in
  // turn: of one observation alone pixels cannot tell.
  problem.observation_camera.resize(1);
  problem.observation_point.resize(1);
  problem.observations.resize(2);
  const double* camera = &problem.cameras[9 * std::size_t(problem.observation_camera[0])];
  double* point = &problem.points[3 * std::size_t(problem.observation_point[0])];
  const Vector3d P = -so3::exp(Vector3d(camera[0], camera[1], camera[2])).transpose() *
                     Vector3d(camera[3], camera[4], camera[5]);
  for (int i = 0; i < 3; ++i) point[i] = 2 * P[i] - point[i];
  EXPECT_LE(DenseObjective(problem, pixel).cost(), 1e-12);
  const Formulation focal = {
      .lens = Lens::fixed, .objective = ObjectiveKind::ray, .ray_weight = RayWeight::focal};
  EXPECT_NEAR(DenseObjective(problem, focal).cost(), 0.5 * 4 * camera[6] * camera[6], 1e-6);
}

}  // namespace
}  // namespace raybundle
