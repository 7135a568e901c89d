// What is fixed has no derivative and keeps its bits, whatever the step says.

#include <raybundle/models/objective.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <raybundle/models/error.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/support/dense_objective.h>
#include <raybundle/tests/support/numeric_jacobian.h>
#include <raybundle/tests/support/random_problem.h>
#include <raybundle/tests/support/small_problem.h>
#include <raybundle/tests/support/temporary_folder.h>

namespace raybundle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::DenseObjective;
using test::small_problem;

constexpr std::array updates = {PoseUpdate::global, PoseUpdate::local, PoseUpdate::se3};
constexpr std::array lenses = {Lens::free, Lens::fixed};

constexpr std::uint16_t rotation = 0b000'000'111;
constexpr std::uint16_t translation = 0b000'111'000;
constexpr std::uint16_t pose = rotation | translation;
constexpr std::uint16_t lens_bits = 0b111'000'000;

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

VectorXd random_step(std::int64_t size, double scale, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  return VectorXd::NullaryExpr(size, [&] { return scale * test::uniform(random); });
}

// Masks every update can hold.
Problem masked() {
  Problem problem = small_problem({.seed = 1, .cameras = 5, .points = 10});
  problem.fixed_camera_parameters = {pose, 0, lens_bits, pose | lens_bits, 0b010'000'000};
  problem.fixed_points.assign(10, 0);
  problem.fixed_points[0] = problem.fixed_points[9] = 1;
  // Bits that arithmetic with zero would change.
  problem.cameras[3] = -0.0;
  problem.points[1] = -0.0;
  return problem;
}

TEST(FixedParameters, HaveNoDerivativeAndOthersKeepTheirs) {
  const Problem problem = masked();
  Problem all_free = problem;
  all_free.fixed_camera_parameters.clear();
  all_free.fixed_points.clear();
  for (const PoseUpdate update : updates) {
    for (const Lens lens : lenses) {
      DenseObjective some(problem, update, lens), none(all_free, update, lens);
      const MatrixXd J = some.jacobian();
      MatrixXd expected = none.jacobian();
      const int hub = lens == Lens::free ? 9 : 6;
      for (int c = 0; c < 5; ++c) {
        for (int k = 0; k < hub; ++k) {
          if ((problem.fixed_camera_parameters[static_cast<std::size_t>(c)] >> k & 1) != 0) {
            expected.col(c * hub + k).setZero();
          }
        }
      }
      for (const int i : {0, 9}) expected.middleCols(5 * hub + 3 * i, 3).setZero();
      EXPECT_TRUE(J == expected);
      EXPECT_TRUE(some.residual() == none.residual()) << "residuals do not depend on masks";
    }
  }
}

TEST(FixedParameters, KeepTheirBits) {
  const Problem problem = masked();
  for (const PoseUpdate update : updates) {
    for (const Lens lens : lenses) {
      DenseObjective dense(problem, update, lens);
      // A solver gives fixed unknowns a zero step, of either sign.
      for (const double zero : {0.0, -0.0}) {
        VectorXd step = random_step(dense.objective().layout().unknowns(), 0.1, 2);
        const int hub = dense.objective().layout().hub_size;
        for (int c = 0; c < 5; ++c) {
          for (int k = 0; k < hub; ++k) {
            if ((problem.fixed_camera_parameters[static_cast<std::size_t>(c)] >> k & 1) != 0) {
              step[c * hub + k] = zero;
            }
          }
        }
        for (const int i : {0, 9}) step.segment(5 * hub + 3 * i, 3).setConstant(zero);
        const State next = dense.after(step);
        for (std::size_t c = 0; c < 5; ++c) {
          for (std::size_t k = 0; k < 9; ++k) {
            const bool fixed = (problem.fixed_camera_parameters[c] >> k & 1) != 0 ||
                               (k >= 6 && lens == Lens::fixed);
            const double before = problem.cameras[9 * c + k], after = next.cameras[9 * c + k];
            EXPECT_EQ(same_bits(before, after), fixed) << "camera " << c << ", parameter " << k;
          }
        }
        for (std::size_t i = 0; i < 10; ++i) {
          for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_EQ(same_bits(problem.points[3 * i + k], next.points[3 * i + k]),
                      i == 0 || i == 9)
                << "point " << i;
          }
        }
      }
    }
  }
}

// A fixed point stays in the world, not where its anchors see it.
TEST(FixedParameters, AnchoredPointsStayWhileTheirAnchorsMove) {
  Problem problem = small_problem({.seed = 1, .cameras = 5, .points = 10});
  problem.fixed_points.assign(10, 0);
  problem.fixed_points[0] = problem.fixed_points[9] = 1;
  for (const PointModel points : {PointModel::idp, PointModel::pba, PointModel::pmba}) {
    DenseObjective dense(problem, {.lens = Lens::fixed, .points = points});
    VectorXd step = random_step(dense.objective().layout().unknowns(), 0.02, 3);
    for (const int i : {0, 9}) step.segment(30 + 3 * i, 3).setZero();
    Problem moved = problem;
    dense.objective().write(dense.after(step), moved);
    for (const std::size_t i : {0U, 9U}) {
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_TRUE(same_bits(moved.points[3 * i + k], problem.points[3 * i + k]));
      }
    }
    const double expected = reprojection_statistics(moved).cost;
    EXPECT_NEAR(dense.cost_after(step), expected, 1e-9 * expected);
    const MatrixXd numeric = test::numeric_jacobian(
        [&](const VectorXd& delta) {
          VectorXd held = delta;
          for (const int i : {0, 9}) held.segment(30 + 3 * i, 3).setZero();
          return dense.residual_after(held);
        },
        VectorXd::Zero(step.size()), 0.01);
    EXPECT_LE((dense.jacobian() - numeric).norm(), 1e-7 * numeric.norm());
  }
}

TEST(FixedParameters, AnchorsThatStayAndPointsThatStayHaveNoEffect) {
  const Problem problem = masked();
  for (const PointModel points : {PointModel::idp, PointModel::pmba}) {
    DenseObjective dense(problem, {.pose_update = PoseUpdate::global, .points = points});
    const linalg::BlockLayout& layout = dense.objective().layout();
    for (std::size_t i = 0; i < 10; ++i) {
      for (auto k = layout.anchorage.begin[i]; k < layout.anchorage.begin[i + 1]; ++k) {
        const auto coupling = layout.anchorage.coupling[static_cast<std::size_t>(k)];
        const auto camera = layout.hub_side.block[static_cast<std::size_t>(coupling)];
        const bool stays = i == 0 || i == 9 || camera == 0 || camera == 3;
        const Eigen::Map<const VectorXd> Z(dense.blocks().anchor_blocks.data() + k * 27, 27);
        EXPECT_EQ(Z.isZero(0), stays) << "point " << i << ", camera " << camera;
      }
    }
    // Nor is a fixed point among those whose step is taken back.
    VectorXd step = random_step(layout.unknowns(), 10, 4);
    State scratch = dense.state();
    EXPECT_LE(dense.objective().hold_worse_points(dense.state(), step.data(), scratch), 8);
  }
}

// Every mask of a pose is either held to the bit or refused; none is bent.
TEST(FixedParameters, EveryPoseMaskIsHeldOrRefused) {
  for (const PoseUpdate update : updates) {
    for (std::uint16_t mask = 0; mask < 64; ++mask) {
      Problem problem = small_problem({.seed = 3});
      problem.fixed_camera_parameters.assign(4, mask);
      const bool whole_parts = ((mask & rotation) == 0 || (mask & rotation) == rotation) &&
                               ((mask & translation) == 0 || (mask & translation) == translation);
      const bool legal = update == PoseUpdate::global ||
                         (update == PoseUpdate::local && whole_parts) ||
                         (update == PoseUpdate::se3 && (mask == 0 || mask == pose));
      if (!legal) {
        EXPECT_THROW(DenseObjective(problem, update, Lens::free), InputError) << mask;
        continue;
      }
      DenseObjective dense(problem, update, Lens::free);
      VectorXd step = random_step(dense.objective().layout().unknowns(), 0.1, 4);
      for (int k = 0; k < 36; ++k) {
        if ((mask >> k % 9 & 1) != 0) step[k] = 0;
      }
      const State next = dense.after(step);
      for (std::size_t k = 0; k < 36; ++k) {
        if ((mask >> k % 9 & 1) == 0) continue;
        EXPECT_TRUE(same_bits(problem.cameras[k], next.cameras[k])) << mask << ", " << k;
      }
      // What is left free really moves the way its derivative says: one of the two fixed parts
      // being held must not disturb the other.
      const VectorXd tiny = 1e-7 * step;
      const VectorXd linear = dense.residual() + dense.jacobian() * tiny;
      EXPECT_LE((dense.residual_after(tiny) - linear).norm(),
                1e-3 * (dense.jacobian() * tiny).norm())
          << mask;
    }
  }
}

TEST(FixedParameters, AZeroStepKeepsAllBits) {
  const Problem problem = small_problem({.seed = 5, .unobserved_cameras = 1});
  for (const PoseUpdate update : updates) {
    DenseObjective dense(problem, update, Lens::free);
    const State next = dense.after(VectorXd::Zero(dense.objective().layout().unknowns()));
    EXPECT_EQ(next.cameras, problem.cameras);
    EXPECT_TRUE(std::ranges::equal(next.points, problem.points));
  }
}

// A rotation is its rotation vector whatever the update: what is written is what was solved.
TEST(State, CostHasTheSameBitsAfterWritingAndReading) {
  const test::TemporaryFolder folder;
  for (const PoseUpdate update : updates) {
    Problem problem = small_problem({.seed = 6, .points = 40});
    DenseObjective dense(problem, update, Lens::free);
    const VectorXd step = random_step(dense.objective().layout().unknowns(), 1e-2, 7);
    State next = dense.after(step);
    const double cost = dense.objective().cost(next);
    problem.cameras = next.cameras;
    problem.points.assign(next.points.begin(), next.points.end());
    const std::string path = (folder / "moved.txt").string();
    io::write_bal(problem, path);
    const Problem read = io::read_bal(path);
    DenseObjective again(read, update, Lens::free);
    EXPECT_EQ(again.objective().cost(again.state()), cost);
    EXPECT_EQ(read.cameras, next.cameras);
  }
}

}  // namespace
}  // namespace raybundle
