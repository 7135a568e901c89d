// The Objective's value and derivatives. The oracle of every value is reprojection_statistics(),
// which shares no code with the kernels.

#include <raybundle/models/objective.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

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
using Eigen::VectorXd;
using test::DenseObjective;
using test::small_problem;

constexpr double pi = 3.14159265358979323846;

std::string name_of(PoseUpdate update) {
  return update == PoseUpdate::global ? "Global" : (update == PoseUpdate::local ? "Local" : "Se3");
}

// Turns the world, cameras and points alike, so that camera 0 has this rotation angle.
Problem with_first_angle(Problem problem, double angle) {
  using so3::Vector3;
  const Vector3 phi = Eigen::Map<const Vector3>(problem.cameras.data());
  const Eigen::Matrix3d wanted = so3::exp(angle * phi.normalized());
  const Eigen::Matrix3d turn = wanted.transpose() * so3::exp(phi);  // R_new = R turn^-1
  for (std::size_t j = 0; j < problem.cameras.size(); j += 9) {
    Eigen::Map<Vector3> camera(&problem.cameras[j]);
    const Eigen::Matrix3d R = so3::exp(Vector3(camera)) * turn.transpose();
    camera = so3::log(R);
  }
  for (std::size_t i = 0; i < problem.points.size(); i += 3) {
    Eigen::Map<Vector3> X(&problem.points[i]);
    X = turn * Vector3(X);
  }
  Eigen::Map<Vector3>(problem.cameras.data()) = angle * phi.normalized();
  return problem;
}

std::vector<Problem> problems() {
  std::vector<Problem> list;
  list.push_back(small_problem({.seed = 1}));
  list.push_back(small_problem({.seed = 2,
                                .cameras = 5,
                                .points = 12,
                                .duplicate_observations = 4,
                                .unobserved_cameras = 1,
                                .unobserved_points = 2,
                                .points_seen_once = 2,
                                .shuffled = true}));
  for (const double angle : {0.0, 1e-9, 1e-4, pi - 1e-4, pi - 1e-9}) {
    list.push_back(with_first_angle(small_problem({.seed = 3, .points = 8}), angle));
  }
  return list;
}

using Variant = std::tuple<PoseUpdate, Lens>;

class ObjectiveOf : public ::testing::TestWithParam<Variant> {
 protected:
  PoseUpdate update() const { return std::get<0>(GetParam()); }
  Lens lens() const { return std::get<1>(GetParam()); }
};

TEST_P(ObjectiveOf, LayoutMatchesTheProblem) {
  const Problem problem = problems()[1];
  DenseObjective dense(problem, update(), lens());
  const linalg::BlockLayout& layout = dense.objective().layout();
  EXPECT_EQ(layout.hubs, 5);
  EXPECT_EQ(layout.leaves, 12);
  EXPECT_EQ(layout.rows, problem.observation_count());
  EXPECT_EQ(layout.hub_size, lens() == Lens::free ? 9 : 6);
}

TEST_P(ObjectiveOf, CostAgreesWithTheStatistics) {
  for (const Problem& problem : problems()) {
    DenseObjective dense(problem, update(), lens());
    const double expected = reprojection_statistics(problem).cost;
    EXPECT_NEAR(dense.cost(), expected, 1e-12 * expected);
    EXPECT_NEAR(0.5 * dense.residual().squaredNorm(), expected, 1e-12 * expected);
  }
}

TEST_P(ObjectiveOf, CostAndLinearizeAgree) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    DenseObjective dense(small_problem({.seed = seed, .points = 300}), update(), lens());
    const double cost = dense.objective().cost(dense.state());
    EXPECT_NEAR(cost, dense.cost(), 1e-14 * cost) << "seed " << seed;
  }
}

TEST_P(ObjectiveOf, JacobianAgreesWithDifferences) {
  for (const Problem& problem : problems()) {
    DenseObjective dense(problem, update(), lens());
    const MatrixXd numeric =
        test::numeric_jacobian([&](const VectorXd& step) { return dense.residual_after(step); },
                               VectorXd::Zero(dense.objective().layout().unknowns()), 0.1);
    const MatrixXd analytic = dense.jacobian();
    for (Eigen::Index i = 0; i < analytic.cols(); ++i) {
      EXPECT_LE((analytic.col(i) - numeric.col(i)).norm(), 1e-8 * (analytic.col(i).norm() + 1))
          << "unknown " << i;
    }
  }
}

TEST_P(ObjectiveOf, TaylorRemainderIsOfSecondOrder) {
  for (const Problem& problem : problems()) {
    DenseObjective dense(problem, update(), lens());
    std::mt19937_64 random(7);
    VectorXd direction(dense.objective().layout().unknowns());
    for (double& x : direction) x = 0.2 * test::uniform(random);
    const VectorXd derivative = dense.jacobian() * direction;
    EXPECT_TRUE(test::has_taylor_slope_two(
        [&](double tau) { return dense.residual_after(tau * direction); }, derivative));
    // The check can fail: a wrong derivative shows.
    EXPECT_FALSE(test::has_taylor_slope_two(
        [&](double tau) { return dense.residual_after(tau * direction); }, 1.01 * derivative));
  }
}

TEST_P(ObjectiveOf, SameBitsForAnyNumberOfThreads) {
  const Problem problem = small_problem({.seed = 9, .cameras = 9, .points = 900});
  DenseObjective one(problem, update(), lens(), 1);
  for (const int threads : {2, 3}) {
    DenseObjective many(problem, update(), lens(), threads);
    EXPECT_EQ(one.cost(), many.cost());
    EXPECT_TRUE(one.residual() == many.residual());
    EXPECT_TRUE(one.same_rows(many));
    const VectorXd step = VectorXd::Constant(one.objective().layout().unknowns(), 1e-3);
    EXPECT_EQ(one.after(step).cameras, many.after(step).cameras);
    EXPECT_EQ(one.after(step).points, many.after(step).points);
  }
}

INSTANTIATE_TEST_SUITE_P(Variants, ObjectiveOf,
                         ::testing::Combine(::testing::Values(PoseUpdate::global, PoseUpdate::local,
                                                              PoseUpdate::se3),
                                            ::testing::Values(Lens::free, Lens::fixed)),
                         [](const auto& test) {
                           return name_of(std::get<0>(test.param)) +
                                  (std::get<1>(test.param) == Lens::free ? "Free" : "Fixed");
                         });

TEST(Objective, OrderOfObservationsDoesNotMatter) {
  Problem problem = small_problem({.seed = 4, .points = 30});
  Problem reversed = problem;
  const auto flip = [](auto& values) { std::reverse(values.begin(), values.end()); };
  flip(reversed.observation_camera);
  flip(reversed.observation_point);
  flip(reversed.observations);
  for (std::size_t k = 0; k < reversed.observations.size(); k += 2) {
    std::swap(reversed.observations[k], reversed.observations[k + 1]);
  }
  DenseObjective a(problem, PoseUpdate::local, Lens::free);
  DenseObjective b(reversed, PoseUpdate::local, Lens::free);
  EXPECT_EQ(a.cost(), b.cost());
  EXPECT_TRUE(a.residual() == b.residual());
}

TEST(Objective, PointsInTheCameraPlaneGiveACostThatIsNotFinite) {
  Problem problem = small_problem({.seed = 5});
  // The first observation's camera, put where z is exactly 0 for the point it sees.
  const auto j = static_cast<std::size_t>(problem.observation_camera[0]);
  const auto i = static_cast<std::size_t>(problem.observation_point[0]);
  std::fill_n(problem.cameras.begin() + static_cast<std::ptrdiff_t>(9 * j), 6, 0.0);
  problem.points[3 * i + 2] = 0;
  DenseObjective dense(problem, PoseUpdate::local, Lens::free);
  EXPECT_FALSE(std::isfinite(dense.cost()));
  EXPECT_FALSE(std::isfinite(dense.objective().cost(dense.state())));
}

TEST(Objective, RelativeStepIsBlockwise) {
  const Problem problem =
      small_problem({.seed = 6, .cameras = 2, .points = 3, .observations_per_point = 2});
  DenseObjective dense(problem, PoseUpdate::global, Lens::free);
  const State from = dense.state();
  VectorXd step = VectorXd::Zero(dense.objective().layout().unknowns());
  const auto relative = [&] { return dense.objective().relative_step(from, step.data(), 1e-8); };
  const auto change = [&](bool camera, std::size_t at, double delta) {
    step.setZero();
    step[static_cast<Eigen::Index>(at + (camera ? 0 : from.cameras.size()))] = delta;
    return relative();
  };
  const auto norm = [&](const auto& x, std::size_t at, int size) {
    return Eigen::Map<const VectorXd>(&x[at], size).norm();
  };
  EXPECT_EQ(relative(), 0);
  // Rotation, translation, focal length and distortion of camera 1, and the last point: each is
  // measured against itself only.
  constexpr double eps = 1e-9;
  EXPECT_NEAR(change(true, 9, 1e-3), 1e-3 / (norm(from.cameras, 9, 3) + 1e-8), eps);
  EXPECT_NEAR(change(true, 13, -1e-3), 1e-3 / (norm(from.cameras, 12, 3) + 1e-8), eps);
  EXPECT_NEAR(change(true, 15, 10), 10 / (std::abs(from.cameras[15]) + 1e-8), eps);
  EXPECT_NEAR(change(true, 17, 1e-6), 1e-6 / (norm(from.cameras, 16, 2) + 1e-8), eps);
  EXPECT_NEAR(change(false, 8, 1e-3), 1e-3 / (norm(from.points, 6, 3) + 1e-8), eps);

  step.setZero();
  step[6] = 1;      // a five-hundredth
  step[18] = 0.25;  // much more of its norm
  EXPECT_NEAR(relative(), 0.25 / (norm(from.points, 0, 3) + 1e-8), eps);
}

// A zero block that does not move must not hide or invent anything, at any tolerance.
TEST(Objective, RelativeStepOfZeroBlocks) {
  Problem problem = small_problem({.seed = 6});
  std::fill_n(problem.cameras.begin(), 6, 0.0);
  DenseObjective dense(problem, PoseUpdate::global, Lens::free);
  const State from = dense.state();
  const VectorXd step = VectorXd::Zero(dense.objective().layout().unknowns());
  EXPECT_EQ(dense.objective().relative_step(from, step.data(), 0.0), 0);
}

}  // namespace
}  // namespace raybundle
