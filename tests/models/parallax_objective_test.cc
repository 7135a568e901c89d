// The Objective with anchored points and with rays: value, derivatives, conversion. The oracle of
// values works in coordinates of the world and shares no code with the kernels.

#include <raybundle/models/objective.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <raybundle/models/rays.h>
#include <raybundle/models/rotation.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/support/dense_objective.h>
#include <raybundle/tests/support/numeric_jacobian.h>
#include <raybundle/tests/support/random_problem.h>
#include <raybundle/tests/support/small_problem.h>
#include <raybundle/tests/support/taylor.h>

namespace raybundle {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::DenseObjective;
using test::small_problem;

Eigen::Vector2d project(const double* lens, const Vector3d& d) {
  const Eigen::Vector2d p = -d.head<2>() / d.z();
  const double n = p.squaredNorm();
  return lens[0] * (1 + lens[1] * n + lens[2] * n * n) * p;
}

// What a difference of rays at `ray` is in pixels, by differences; along the ray f.
Eigen::Matrix3d pixels_of(const double* lens, const Vector3d& ray) {
  constexpr double h = 1e-5;
  Eigen::Matrix3d W;
  for (int i = 0; i < 3; ++i) {
    const Vector3d e = h * Vector3d::Unit(i);
    W.col(i).head<2>() = (project(lens, ray + e) - project(lens, ray - e)) / (2 * h);
  }
  W.row(2) = lens[0] * ray.transpose();
  return W;
}

// 1/2 sum |W (xi(X_c) - v)|^2, spelled out.
double ray_cost(const Problem& problem, RayWeight weight) {
  const std::vector<double> rays = observed_rays(problem);
  double sum = 0;
  for (std::size_t k = 0; k < problem.observation_camera.size(); ++k) {
    const double* camera = &problem.cameras[9 * std::size_t(problem.observation_camera[k])];
    const double* point = &problem.points[3 * std::size_t(problem.observation_point[k])];
    const Vector3d X_c = so3::exp(Vector3d(camera[0], camera[1], camera[2])) *
                             Vector3d(point[0], point[1], point[2]) +
                         Vector3d(camera[3], camera[4], camera[5]);
    const Vector3d ray(rays[3 * k], rays[3 * k + 1], rays[3 * k + 2]);
    Eigen::Matrix3d W = Eigen::Matrix3d::Identity();
    if (weight == RayWeight::focal) W *= camera[6];
    if (weight == RayWeight::pixel) W = pixels_of(camera + 6, ray);
    sum += (W * (X_c.normalized() - ray)).squaredNorm();
  }
  return 0.5 * sum;
}

double expected_cost(const Problem& problem, const Formulation& formulation) {
  return formulation.objective == ObjectiveKind::ray ? ray_cost(problem, formulation.ray_weight)
                                                     : reprojection_statistics(problem).cost;
}

std::vector<Problem> problems() {
  return {small_problem({.seed = 1}), small_problem({.seed = 2,
                                                     .cameras = 5,
                                                     .points = 14,
                                                     .duplicate_observations = 4,
                                                     .unobserved_cameras = 1,
                                                     .unobserved_points = 2,
                                                     .points_seen_once = 2,
                                                     .far_points = 2,
                                                     .shuffled = true})};
}

std::string name_of(const Formulation& f) {
  constexpr const char* models[] = {"Xyz", "Idp", "Pba", "Pmba"};
  constexpr const char* updates[] = {"Global", "Local", "Se3"};
  const std::string objective =
      f.objective == ObjectiveKind::ray
          ? std::array{"Ray", "FocalRay", "UnitRay"}[static_cast<std::size_t>(f.ray_weight)]
          : (f.lens == Lens::free ? "PixelLens" : "Pixel");
  return models[static_cast<int>(f.points)] + objective + updates[static_cast<int>(f.pose_update)];
}

std::vector<Formulation> formulations() {
  std::vector<Formulation> list;
  for (const auto points : {PointModel::xyz, PointModel::idp, PointModel::pba, PointModel::pmba}) {
    for (const auto update : {PoseUpdate::global, PoseUpdate::local, PoseUpdate::se3}) {
      for (const Lens lens : {Lens::free, Lens::fixed}) {
        list.push_back({.pose_update = update, .lens = lens, .points = points});
      }
      for (const RayWeight weight : {RayWeight::pixel, RayWeight::focal, RayWeight::unit}) {
        list.push_back({.pose_update = update,
                        .lens = Lens::fixed,
                        .points = points,
                        .objective = ObjectiveKind::ray,
                        .ray_weight = weight});
      }
    }
  }
  return list;
}

class FormulationOf : public ::testing::TestWithParam<Formulation> {};

TEST_P(FormulationOf, CostIsThatOfThePointsInTheWorld) {
  for (const Problem& problem : problems()) {
    DenseObjective dense(problem, GetParam());
    Problem written = problem;
    dense.objective().write(dense.state(), written);
    const double expected = expected_cost(written, GetParam());
    EXPECT_NEAR(dense.cost(), expected, 1e-9 * expected);
    EXPECT_NEAR(dense.objective().cost(dense.state()), dense.cost(), 1e-13 * dense.cost());
    EXPECT_NEAR(0.5 * dense.residual().squaredNorm(), expected, 1e-9 * expected);
    const double pixels = reprojection_statistics(written).cost;
    EXPECT_NEAR(dense.objective().pixel_cost(dense.state()), pixels, 1e-9 * pixels);
  }
}

TEST_P(FormulationOf, ProblemIsWrittenAsItWasRead) {
  for (const Problem& problem : problems()) {
    DenseObjective dense(problem, GetParam());
    Problem written = problem;
    std::fill(written.points.begin(), written.points.begin() + 3 * 4, 77.0);
    dense.objective().write(dense.state(), written);
    EXPECT_EQ(written.cameras, problem.cameras);
    for (std::size_t i = 0; i < problem.points.size(); i += 3) {
      const Vector3d X(&problem.points[i]), Y(&written.points[i]);
      // A parallax is known to 1e-16 of a radian: of far points the distance is not.
      const double known = 1e-14 * X.squaredNorm() / 5 + 1e-12;
      EXPECT_LE((X - Y).norm(), known) << "point " << i / 3;
    }
  }
}

TEST_P(FormulationOf, JacobianAgreesWithDifferences) {
  for (const Problem& problem : problems()) {
    DenseObjective dense(problem, GetParam());
    const MatrixXd numeric =
        test::numeric_jacobian([&](const VectorXd& step) { return dense.residual_after(step); },
                               VectorXd::Zero(dense.objective().layout().unknowns()), 0.01);
    const MatrixXd analytic = dense.jacobian();
    for (Eigen::Index i = 0; i < analytic.cols(); ++i) {
      EXPECT_LE((analytic.col(i) - numeric.col(i)).norm(), 1e-7 * (analytic.col(i).norm() + 1))
          << "unknown " << i;
    }
  }
}

TEST_P(FormulationOf, TaylorRemainderIsOfSecondOrder) {
  DenseObjective dense(problems()[0], GetParam());
  std::mt19937_64 random(7);
  VectorXd direction(dense.objective().layout().unknowns());
  for (double& x : direction) x = 0.05 * test::uniform(random);
  const VectorXd derivative = dense.jacobian() * direction;
  EXPECT_TRUE(test::has_taylor_slope_two(
      [&](double tau) { return dense.residual_after(tau * direction); }, derivative));
  EXPECT_FALSE(test::has_taylor_slope_two(
      [&](double tau) { return dense.residual_after(tau * direction); }, 1.01 * derivative));
}

TEST_P(FormulationOf, SameBitsForAnyNumberOfThreads) {
  const Problem problem = small_problem({.seed = 9, .cameras = 9, .points = 700});
  DenseObjective one(problem, GetParam(), 1), many(problem, GetParam(), 3);
  EXPECT_EQ(one.cost(), many.cost());
  EXPECT_TRUE(one.residual() == many.residual());
  EXPECT_TRUE(one.same_rows(many));
  EXPECT_EQ(one.blocks().anchor_blocks, many.blocks().anchor_blocks);
  const VectorXd step = VectorXd::Constant(one.objective().layout().unknowns(), 1e-3);
  EXPECT_EQ(one.after(step).points, many.after(step).points);
}

TEST_P(FormulationOf, LossWeighsResidualsAndDerivativesAlike) {
  const Problem problem = problems()[0];
  const RobustLoss loss = {.kind = Loss::cauchy, .scale = 0.5};
  DenseObjective plain(problem, GetParam()), robust(problem, GetParam(), 2, loss);
  const int size = plain.objective().layout().row_size;
  double cost = 0;
  for (Eigen::Index row = 0; row < plain.residual().size() / size; ++row) {
    const LossValue value =
        evaluate(loss, plain.residual().segment(row * size, size).squaredNorm());
    cost += 0.5 * value.rho;
    const MatrixXd expected =
        std::sqrt(value.weight) * plain.jacobian().middleRows(row * size, size);
    EXPECT_LE((robust.jacobian().middleRows(row * size, size) - expected).norm(),
              1e-13 * (expected.norm() + 1e-300));
  }
  EXPECT_NEAR(robust.cost(), cost, 1e-12 * cost);
}

INSTANTIATE_TEST_SUITE_P(All, FormulationOf, ::testing::ValuesIn(formulations()),
                         [](const auto& test) { return name_of(test.param); });

// Of a large random step, those points keep their part that are better off with it.
void expect_worse_points_held(const Formulation& formulation, const RobustLoss& loss) {
  const Problem problem = small_problem({.seed = 5, .cameras = 5, .points = 40});
  DenseObjective dense(problem, formulation, 2, loss);
  std::mt19937_64 random(8);
  VectorXd step(dense.objective().layout().unknowns());
  for (double& x : step) x = 1e-4 * test::uniform(random);
  const Eigen::Index cameras = step.size() - 3 * 40;
  VectorXd kept = step;
  State scratch = dense.state();
  const std::int64_t held =
      dense.objective().hold_worse_points(dense.state(), kept.data(), scratch);
  EXPECT_TRUE(kept.head(cameras) == step.head(cameras));
  std::int64_t counted = 0;
  const double before = dense.cost_after(kept);
  for (Eigen::Index i = 0; i < 40; ++i) {
    const auto part = kept.segment<3>(cameras + 3 * i), given = step.segment<3>(cameras + 3 * i);
    const bool stays = part.isZero(0);
    EXPECT_TRUE(stays || part == given);
    counted += stays ? 1 : 0;
    VectorXd other = kept;  // the other choice for this point, all else the same
    if (stays) {
      other.segment<3>(cameras + 3 * i) = given;
    } else {
      other.segment<3>(cameras + 3 * i).setZero();
    }
    EXPECT_GE(dense.cost_after(other), before * (1 - 1e-12)) << "point " << i;
  }
  EXPECT_EQ(held, counted);
  EXPECT_GT(held, 0);
  EXPECT_LT(held, 40);
}

TEST_P(FormulationOf, PointsWithAWorseStepAreHeld) {
  expect_worse_points_held(GetParam(), {});
  expect_worse_points_held(GetParam(), {.kind = Loss::huber, .scale = 0.5});
}

TEST_P(FormulationOf, PointsThatAStepMakesUnusableAreHeld) {
  const Problem problem = small_problem({.seed = 5, .cameras = 5, .points = 40});
  DenseObjective dense(problem, GetParam());
  VectorXd step = VectorXd::Zero(dense.objective().layout().unknowns());
  step.tail(3).setConstant(std::numeric_limits<double>::quiet_NaN());
  step[step.size() - 6] = std::numeric_limits<double>::infinity();
  State scratch = dense.state();
  EXPECT_EQ(dense.objective().hold_worse_points(dense.state(), step.data(), scratch), 2);
  EXPECT_TRUE(step.isZero(0));
}

// A start of which every third point lies behind the cameras that saw it, as solves leave those
// beyond infinity.
Problem problem_beyond_infinity() {
  Problem problem = small_problem({.seed = 12, .cameras = 6, .points = 30, .points_seen_once = 3});
  const std::vector<double> rays = observed_rays(problem);
  for (std::size_t k = 0; k < problem.observation_point.size(); ++k) {
    const auto i = std::size_t(problem.observation_point[k]);
    if (i % 3 != 0) continue;
    const double* camera = &problem.cameras[9 * std::size_t(problem.observation_camera[k])];
    const Eigen::Matrix3d R_cw = so3::exp(Vector3d(camera[0], camera[1], camera[2]));
    const Vector3d centre = -R_cw.transpose() * Vector3d(camera[3], camera[4], camera[5]);
    const Vector3d ray(rays[3 * k], rays[3 * k + 1], rays[3 * k + 2]);
    Eigen::Map<Vector3d>(&problem.points[3 * i]) = centre - 1e3 * (R_cw.transpose() * ray);
  }
  return problem;
}

TEST_P(FormulationOf, PointsBeyondInfinityAreReadBackAsSuch) {
  if (!is_anchored(GetParam().points) || GetParam().objective != ObjectiveKind::ray) return;
  const Problem problem = problem_beyond_infinity();
  DenseObjective dense(problem, GetParam());
  const double as_coordinates = ray_cost(problem, GetParam().ray_weight);
  EXPECT_LT(dense.cost(), 0.1 * as_coordinates);
  Problem written = problem;
  dense.objective().write(dense.state(), written);
  EXPECT_NEAR(DenseObjective(written, GetParam()).cost(), dense.cost(), 1e-9 * dense.cost());
  const double pixels = reprojection_statistics(written).cost;
  EXPECT_NEAR(dense.objective().pixel_cost(dense.state()), pixels, 1e-9 * pixels);
}

// Behind one camera that sees it and in front of the others, a point costs no more than it does in
// coordinates: one ray is wrong, not all others.
TEST_P(FormulationOf, APointBehindOneCameraIsInFrontOfTheOthers) {
  if (!is_anchored(GetParam().points) || GetParam().objective != ObjectiveKind::ray) return;
  for (std::int32_t turned = 0; turned < 6; ++turned) {
    Problem problem =
        small_problem({.seed = 13, .cameras = 6, .points = 12, .observations_per_point = 6});
    double* camera = &problem.cameras[9 * std::size_t(turned)];
    const Eigen::Matrix3d R_cw = so3::exp(Vector3d(camera[0], camera[1], camera[2]));
    const Vector3d t_cw(camera[3], camera[4], camera[5]);
    const Eigen::Matrix3d half_turn = Vector3d(-1, 1, -1).asDiagonal();
    const Eigen::Matrix3d R_turned = half_turn * R_cw;
    Eigen::Map<Vector3d>{camera} = so3::log(R_turned);
    Eigen::Map<Vector3d>{camera + 3} = half_turn * t_cw;
    const double as_coordinates = ray_cost(problem, GetParam().ray_weight);
    EXPECT_LE(DenseObjective(problem, GetParam()).cost(), as_coordinates * (1 + 1e-9))
        << "camera " << turned;
  }
}

TEST_P(FormulationOf, FixedPointsBehindTheirCamerasAreThere) {
  if (GetParam().objective != ObjectiveKind::ray) return;
  Problem problem = problem_beyond_infinity();
  problem.fixed_points.assign(30, 1);
  const double expected = ray_cost(problem, GetParam().ray_weight);
  EXPECT_NEAR(DenseObjective(problem, GetParam()).cost(), expected, 1e-6 * expected);
}

}  // namespace
}  // namespace raybundle
