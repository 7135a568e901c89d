// Diagonal matrices entry by entry: which unknown gets which increment's weight, or is held.

#include <raybundle/solver/diagonal_matrix.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/linalg/normal_equations.h>
#include <raybundle/linalg/parallel.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

std::vector<double> inc_matrix(const Increments& inc, PointModel points, Lens lens) {
  const Problem problem = test::small_problem({.cameras = 3, .points = 5});
  linalg::ThreadPool pool(1);
  const Objective objective(problem, {.lens = lens, .points = points}, pool);
  const linalg::NormalEquations normal(objective.layout());
  linalg::LargeVector<double> d;
  fill_diagonal(DiagonalMatrix::inc, inc, points, normal, d, pool);
  return {d.begin(), d.end()};
}

TEST(IncrementMatrix, OfCoordinatesHasTheirUnit) {
  Increments inc = shipped_increments(PointModel::xyz);
  inc.point = 6;
  inc.rotation = 3;
  inc.translation = 2;
  inc.focal = 1;
  const std::vector<double> d = inc_matrix(inc, PointModel::xyz, Lens::free);
  ASSERT_EQ(d.size(), 3u * 9 + 5 * 3);
  for (std::size_t camera = 0; camera < 27; camera += 9) {
    EXPECT_EQ(d[camera + 2], 4);   // (6 / 3)^2
    EXPECT_EQ(d[camera + 3], 9);   // (6 / 2)^2
    EXPECT_EQ(d[camera + 6], 36);  // (6 / 1)^2
  }
  for (std::size_t i = 27; i < d.size(); ++i) EXPECT_EQ(d[i], 1);
}

TEST(IncrementMatrix, OfAnchoredPointsHasTheUnitOfTheirDirections) {
  for (const PointModel points : {PointModel::idp, PointModel::pba, PointModel::pmba}) {
    Increments inc = shipped_increments(points);
    inc.direction = 6;
    inc.parallax = 2;
    inc.rotation = 3;
    inc.translation = 1;
    const std::vector<double> d = inc_matrix(inc, points, Lens::fixed);
    ASSERT_EQ(d.size(), 3u * 6 + 5 * 3);
    for (std::size_t camera = 0; camera < 18; camera += 6) {
      EXPECT_EQ(d[camera], 4);
      EXPECT_EQ(d[camera + 5], 36);
    }
    for (std::size_t point = 18; point < d.size(); point += 3) {
      EXPECT_EQ(d[point], 9);  // inverse distance or theta comes first
      EXPECT_EQ(d[point + 1], 1);
      EXPECT_EQ(d[point + 2], 1);
    }
  }
}

// Entry by entry beside diag(H), with more points than a piece of work has.
TEST(HeldMatrix, HoldsEveryCoordinateOfAPoint) {
  const Problem problem = scenes::street({.seed = 2, .cameras = 20, .points = 5000});
  linalg::ThreadPool pool(2);
  Objective objective(problem, {}, pool);
  linalg::BlockJacobian J(objective.layout());
  linalg::NormalEquations normal(objective.layout());
  (void)objective.linearize(objective.state_of(problem), J, normal);
  const Increments inc = shipped_increments(PointModel::xyz);
  linalg::LargeVector<double> d, held;
  fill_diagonal(DiagonalMatrix::diag_h, inc, PointModel::xyz, normal, d, pool);
  fill_diagonal(DiagonalMatrix::held_h, inc, PointModel::xyz, normal, held, pool);
  ASSERT_EQ(held.size(), d.size());
  for (std::size_t i = 0; i < 20u * 9; ++i) EXPECT_EQ(held[i], d[i]);
  int more = 0;
  for (std::size_t i = 20u * 9; i < d.size(); i += 3) {
    const double most = std::max({d[i], d[i + 1], d[i + 2]});
    for (std::size_t k = i; k < i + 3; ++k) {
      ASSERT_EQ(held[k], std::max(d[k], held_share * most));
      more += held[k] > d[k];
    }
  }
  EXPECT_GT(more, 1000) << "points ahead of the cameras";
}

}  // namespace
}  // namespace raybundle
