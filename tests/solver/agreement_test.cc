// Methods, eliminations, matrices and updates against one another: the same first step, and in the
// end the same minimum.

#include <raybundle/solver/solve.h>

#include <array>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <raybundle/solver/methods.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tests/support/dense_step.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

using Eigen::VectorXd;

constexpr std::array eliminations = {Elimination::none, Elimination::points, Elimination::cameras};
constexpr std::array diagonals = {DiagonalMatrix::identity, DiagonalMatrix::inc,
                                  DiagonalMatrix::diag_h, DiagonalMatrix::held_h};

Problem problem_to_solve() {
  return test::small_problem({.seed = 21,
                              .cameras = 6,
                              .points = 40,
                              .observations_per_point = 4,
                              .duplicate_observations = 3,
                              .unobserved_cameras = 1,
                              .unobserved_points = 1});
}

double minimum(PoseUpdate update, Lens lens) {
  Problem problem = problem_to_solve();
  return solve(problem, {.linear = Linear::dense_cholesky,
                         .pose_update = update,
                         .lens = lens,
                         .max_iterations = 200,
                         .function_tolerance = 0,
                         .gradient_tolerance = 1e-7,
                         .parameter_tolerance = 0})
      .final_cost;
}

TEST(FirstStep, OfTheThreeEliminationsAgrees) {
  for (const PoseUpdate update : {PoseUpdate::global, PoseUpdate::local, PoseUpdate::se3}) {
    for (const DiagonalMatrix damping : diagonals) {
      const double mu = damping >= DiagonalMatrix::diag_h ? 1e-2 : 1;
      std::vector<VectorXd> ends;
      for (const Elimination elimination : eliminations) {
        for (const Linear linear :
             {Linear::dense_cholesky, Linear::sparse_cholesky, Linear::cholmod}) {
          Problem problem = problem_to_solve();
          const Summary summary = solve(problem, {.elimination = elimination,
                                                  .linear = linear,
                                                  .damping_matrix = damping,
                                                  .pose_update = update,
                                                  .max_iterations = 1,
                                                  .initial_damping = mu});
          ASSERT_EQ(summary.accepted, 1);
          VectorXd change(problem.cameras.size() + problem.points.size());
          change << Eigen::Map<VectorXd>(problem.cameras.data(),
                                         static_cast<Eigen::Index>(problem.cameras.size())),
              Eigen::Map<VectorXd>(problem.points.data(),
                                   static_cast<Eigen::Index>(problem.points.size()));
          ends.push_back(change);
        }
      }
      // Relative to each number, so that the focal lengths do not hide the rest.
      const VectorXd size = ends[0].cwiseAbs().array() + 1e-2;
      for (const VectorXd& end : ends) {
        EXPECT_LE((end - ends[0]).cwiseQuotient(size).lpNorm<Eigen::Infinity>(), 1e-8);
      }
    }
  }
}

using Variant = std::tuple<Method, Elimination, DiagonalMatrix, DiagonalMatrix>;

std::vector<Variant> variants() {
  std::vector<Variant> list;
  for (const Elimination side : eliminations) {
    for (const DiagonalMatrix damping : diagonals) {
      list.emplace_back(Method::lm_cholesky, side, damping, DiagonalMatrix::identity);
      for (const DiagonalMatrix scaling : diagonals) {
        list.emplace_back(Method::tnm, side, damping, scaling);
        list.emplace_back(Method::dinm, side, damping, scaling);
      }
    }
  }
  return list;
}

class SameMinimum : public ::testing::TestWithParam<Variant> {};

TEST_P(SameMinimum, IsReached) {
  const auto& [method, elimination, damping, scaling] = GetParam();
  const double expected = minimum(PoseUpdate::local, Lens::fixed);
  Problem problem = problem_to_solve();
  Options options = {.method = method,
                     .elimination = elimination,
                     .damping_matrix = damping,
                     .lens = Lens::fixed,
                     .max_iterations = 300,
                     .function_tolerance = 1e-12};
  if (method != Method::lm_cholesky) {
    options.scaling = scaling;
    options.forcing = 1e-2;
  }
  const Summary summary = solve(problem, options);
  EXPECT_NEAR(summary.final_cost, expected, 1e-7 * expected)
      << name(summary.termination) << " after " << summary.iterations.size();
  EXPECT_EQ(outcome(summary.termination), Outcome::converged) << summary.message;
}

INSTANTIATE_TEST_SUITE_P(Variants, SameMinimum, ::testing::ValuesIn(variants()),
                         [](const auto& variant) {
                           const Method method = std::get<0>(variant.param);
                           const char* who = method == Method::lm_cholesky ? "Cholesky"
                                             : method == Method::tnm       ? "Pcg"
                                                                           : "Bounded";
                           return std::string(who) + name(std::get<1>(variant.param)) + "Damp" +
                                  test::letter(std::get<2>(variant.param)) + "Scale" +
                                  test::letter(std::get<3>(variant.param));
                         });

// Every method as it comes, and every forcing rule.
TEST(SameMinimumByDefault, IsReachedByEveryMethod) {
  const double expected = minimum(PoseUpdate::local, Lens::free);
  for (int k = 0; k < enum_count<Method>; ++k) {
    for (int rule = 0; rule < enum_count<ForcingRule>; ++rule) {
      Options options = {.method = static_cast<Method>(k),
                         .loss = Loss::none,
                         .max_iterations = 300,
                         .function_tolerance = 1e-12};
      const bool iterates = traits(options.method).inner == InnerSolve::pcg;
      if (iterates) {
        options.forcing_rule = static_cast<ForcingRule>(rule);
      }
      Problem problem = problem_to_solve();
      const Summary summary = solve(problem, options);
      EXPECT_NEAR(summary.final_cost, expected, 1e-6 * expected)
          << name(options.method) << " " << name(static_cast<ForcingRule>(rule)) << " "
          << name(summary.termination) << " after " << summary.iterations.size();
      EXPECT_EQ(outcome(summary.termination), Outcome::converged) << summary.message;
    }
  }
}

TEST(SameMinimumOf, AllPoseUpdatesAndLenses) {
  for (const Lens lens : {Lens::free, Lens::fixed}) {
    const double expected = minimum(PoseUpdate::local, lens);
    EXPECT_NEAR(minimum(PoseUpdate::global, lens), expected, 1e-8 * expected);
    EXPECT_NEAR(minimum(PoseUpdate::se3, lens), expected, 1e-8 * expected);
  }
  EXPECT_LT(minimum(PoseUpdate::local, Lens::free), minimum(PoseUpdate::local, Lens::fixed));
}

TEST(SameMinimumOf, AllPreconditioners) {
  const double expected = minimum(PoseUpdate::local, Lens::free);
  for (const Elimination elimination : eliminations) {
    for (int k = 0; k < enum_count<Preconditioner>; ++k) {
      if (elimination == Elimination::none && k > 2) continue;
      if (elimination == Elimination::cameras && k > 4) continue;
      const auto preconditioner = static_cast<Preconditioner>(k);
      if (preconditioner == Preconditioner::identity) continue;  // hopeless among f, k1 and k2
      Problem problem = problem_to_solve();
      const Summary summary = solve(problem, {.method = Method::tnm,
                                              .elimination = elimination,
                                              .preconditioner = preconditioner,
                                              .max_iterations = 300,
                                              .function_tolerance = 1e-12,
                                              .forcing = 1e-3});
      EXPECT_NEAR(summary.final_cost, expected, 1e-6 * expected)
          << name(elimination) << ", " << name(preconditioner) << ", " << summary.message;
    }
  }
}

// The truth fits exactly: whatever the way, the cost goes to zero.
TEST(SameMinimumOf, ExactDataIsZero) {
  for (const Method method : {Method::lm_cholesky, Method::tnm}) {
    for (const Elimination elimination : eliminations) {
      Problem problem = test::small_problem({.seed = 22, .points = 40, .pixel_noise = 0});
      const Summary summary = solve(problem, {.method = method,
                                              .elimination = elimination,
                                              .max_iterations = 100,
                                              .function_tolerance = 0,
                                              .parameter_tolerance = 0});
      EXPECT_LE(summary.final_cost, 1e-12 * summary.initial_cost) << name(elimination);
    }
  }
}

}  // namespace
}  // namespace raybundle
