// The decrease of the model that the engine computes for every method, against its definition and
// against the short form of the thesis [Qu18, Eq. 3.102].

#include <raybundle/solver/solve.h>

#include <array>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

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

// -m_k(p_k) + 1/2 g_e^T C^-1 g_e with C the damped eliminated side [Qu18, Eq. 3.101-3.102].
double short_form(const DenseStep& dense, const VectorXd& p, Eigen::Index hubs, bool leaves_go) {
  const Eigen::Index n = p.size();
  const Eigen::Index e = leaves_go ? hubs : 0, e_size = leaves_go ? n - hubs : hubs;
  const Eigen::Index k = leaves_go ? 0 : hubs, k_size = n - e_size;
  const VectorXd s = dense.unit;
  const MatrixXd H = s.asDiagonal() * dense.H_damped * s.asDiagonal();
  const VectorXd g = s.cwiseProduct(dense.gradient);
  const VectorXd x = p.cwiseQuotient(s).segment(k, k_size);
  const Eigen::LDLT<MatrixXd> C(H.block(e, e, e_size, e_size));
  const MatrixXd E = H.block(k, e, k_size, e_size);
  const VectorXd g_e = g.segment(e, e_size);
  const MatrixXd S = H.block(k, k, k_size, k_size) - E * C.solve(MatrixXd(E.transpose()));
  const VectorXd v = g.segment(k, k_size) - E * C.solve(g_e);
  return -v.dot(x) - 0.5 * x.dot(S * x) + 0.5 * g_e.dot(C.solve(g_e));
}

using Variant = std::tuple<Method, Elimination, DiagonalMatrix, DiagonalMatrix>;

std::vector<Variant> variants() {
  constexpr std::array diagonals = {DiagonalMatrix::identity, DiagonalMatrix::inc,
                                    DiagonalMatrix::diag_h};
  std::vector<Variant> list;
  for (const Elimination side : {Elimination::none, Elimination::points, Elimination::cameras}) {
    for (const DiagonalMatrix damping : diagonals) {
      list.emplace_back(Method::lm_cholesky, side, damping, DiagonalMatrix::identity);
      list.emplace_back(Method::tnm, side, damping, DiagonalMatrix::identity);
      list.emplace_back(Method::tnm, side, damping, DiagonalMatrix::diag_h);
    }
  }
  return list;
}

class ModelDecrease : public ::testing::TestWithParam<Variant> {
 protected:
  Options options() const {
    const auto& [method, elimination, damping_matrix, scaling] = GetParam();
    Options options = {.method = method,
                       .elimination = elimination,
                       .damping_matrix = damping_matrix,
                       .max_iterations = 1,
                       .initial_damping = 1e-3,
                       .precision = Precision::double_precision};
    if (method == Method::tnm) {
      options.scaling = scaling;
      options.forcing = 0.3;  // a step that is far from exact
    }
    return options;
  }
};

TEST_P(ModelDecrease, IsTheDefinitionAndTheShortForm) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Problem problem =
        test::small_problem({.seed = seed, .points = 25, .points_seen_once = 1, .far_points = 1});
    DenseObjective at(problem, options().pose_update, Lens::free);
    const DenseStep dense(at, *options().damping_matrix, *options().initial_damping);
    const VectorXd p = StepFixture(at, options()).solve(dense.damping).step;
    if (options().method == Method::tnm) {
      EXPECT_GT(dense.distance(p, dense.step()), 1e-3 * dense.length(p)) << "should be inexact";
    }
    const Summary summary = solve(problem, options());
    ASSERT_EQ(summary.iterations.size(), 2U);
    const IterationRecord& record = summary.iterations[1];
    const double decrease = dense.decrease(p);
    ASSERT_GT(decrease, 0);
    EXPECT_NEAR(record.predicted_decrease, decrease, 1e-9 * decrease);
    EXPECT_NEAR(record.step_norm, p.norm(), 1e-10 * p.norm());
    const double rho = (summary.initial_cost - record.candidate_cost) / record.predicted_decrease;
    EXPECT_NEAR(record.rho, rho, 1e-12) << "[Qu18, Eq. 3.104]";
    EXPECT_NEAR(record.candidate_cost, at.cost_after(p), 1e-12 * at.cost());
    if (options().elimination != Elimination::none) {
      const bool leaves_go = options().elimination == Elimination::points;
      const Eigen::Index hubs = at.objective().layout().size(linalg::Side::hubs);
      EXPECT_NEAR(record.predicted_decrease, short_form(dense, p, hubs, leaves_go),
                  1e-8 * decrease);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Variants, ModelDecrease, ::testing::ValuesIn(variants()),
                         [](const auto& variant) {
                           const bool exact = std::get<0>(variant.param) == Method::lm_cholesky;
                           return std::string(exact ? "Cholesky" : "Pcg") +
                                  name(std::get<1>(variant.param)) + "Damp" +
                                  test::letter(std::get<2>(variant.param)) + "Scale" +
                                  test::letter(std::get<3>(variant.param));
                         });

// For the exact step the decrease is half of what the slope promises.
TEST(ModelDecreaseOfTheExactStep, IsHalfTheSlope) {
  Problem problem = test::small_problem({.seed = 4});
  DenseObjective at(problem, PoseUpdate::local, Lens::free);
  const DenseStep dense(at, DiagonalMatrix::held_h, 1e-4);
  const Summary summary = solve(problem, {.max_iterations = 1, .initial_damping = 1e-4});
  const double half = -0.5 * dense.gradient.dot(dense.step());
  EXPECT_NEAR(summary.iterations.at(1).predicted_decrease, half, 1e-7 * half);
}

}  // namespace
}  // namespace raybundle
