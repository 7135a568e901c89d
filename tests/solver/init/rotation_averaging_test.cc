// Rotations from relative ones: exact without noise, better than a tree with it, and unmoved by
// edges that are wrong.

#include <raybundle/solver/init/rotation_averaging.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/tests/solver/init/two_views.h>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;

struct Graph {
  std::vector<Matrix3d> truth;
  std::vector<RelativeRotation> edges;
  std::vector<bool> wrong;
};

// Images in a row, each with edges to the next few.
Graph row_of_images(std::int32_t images, double noise, double wrong_share, std::uint64_t seed = 1) {
  Random random(seed, 9);
  Graph graph;
  graph.truth.reserve(static_cast<std::size_t>(images));
  for (std::int32_t i = 0; i < images; ++i) graph.truth.push_back(test::random_rotation(random, 2));
  for (std::int32_t i = 0; i < images; ++i) {
    for (std::int32_t j = i + 1; j < std::min(images, i + 6); ++j) {
      const bool wrong = random.uniform() < wrong_share;
      const Matrix3d error = wrong ? test::random_rotation(random, random.uniform(0.5, 3))
                                   : so3::exp(Eigen::Vector3d(noise * test::random_vector(random)));
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      graph.edges.push_back(
          {i, j, error * graph.truth[b] * graph.truth[a].transpose(), random.uniform(50, 100)});
      graph.wrong.push_back(wrong);
    }
  }
  return graph;
}

double worst_error(const Graph& graph, const AveragedRotations& found) {
  const auto root = static_cast<std::size_t>(found.root);
  double worst = 0;
  for (std::size_t i = 0; i < graph.truth.size(); ++i) {
    const Matrix3d expected = graph.truth[i] * graph.truth[root].transpose();
    worst = std::max(worst, test::angle_between(found.R_cw[i], expected));
  }
  return worst;
}

TEST(RotationAveraging, IsExactWithoutNoise) {
  linalg::ThreadPool pool(2);
  const Graph graph = row_of_images(40, 0, 0);
  const AveragedRotations found = average_rotations(40, graph.edges, {}, pool);
  EXPECT_LT(worst_error(graph, found), 1e-9);
  EXPECT_EQ(std::count(found.pruned.begin(), found.pruned.end(), 1), 0);
  EXPECT_LT(found.after.largest, 1e-9);
}

TEST(RotationAveraging, IsCloserThanATree) {
  linalg::ThreadPool pool(2);
  const Graph graph = row_of_images(60, 0.01, 0);
  const AveragedRotations found = average_rotations(60, graph.edges, {}, pool);
  EXPECT_LT(worst_error(graph, found), 0.06);
  EXPECT_LT(found.after.mean, 0.6 * found.tree.value().mean);
  EXPECT_NEAR(found.after.median, 0.0154, 0.003) << "of |normal vector| with deviation 0.01";
}

TEST(RotationAveraging, WrongEdgesAreFoundAndDoNotMatter) {
  linalg::ThreadPool pool(2);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Graph graph = row_of_images(60, 0.005, 0.2, seed);
    const AveragedRotations found = average_rotations(60, graph.edges, {}, pool);
    EXPECT_LT(worst_error(graph, found), 0.06) << seed;
    for (std::size_t k = 0; k < graph.edges.size(); ++k) {
      EXPECT_EQ(found.pruned[k] != 0, graph.wrong[k]) << seed << " " << k;
    }
  }
}

TEST(RotationAveraging, LeavesOutWhatIsNotConnected) {
  linalg::ThreadPool pool(1);
  Graph graph = row_of_images(20, 0, 0);
  std::erase_if(graph.edges, [](const RelativeRotation& e) { return e.i < 7 && e.j >= 7; });
  const AveragedRotations found = average_rotations(20, graph.edges, {}, pool);
  for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(found.known[i] != 0, i >= 7) << i;
  EXPECT_TRUE(std::isnan(found.angle[0]));
  EXPECT_GE(found.root, 7);
}

// Three images that disagree by a quarter turn along their triangle: all its edges are left out,
// and another triangle, as large but later, is what is left.
TEST(RotationAveraging, AveragesAnotherComponentWhereTheLargestFallsApart) {
  linalg::ThreadPool pool(1);
  const Matrix3d I = Matrix3d::Identity(), quarter = so3::exp(Eigen::Vector3d(0, 0, 1.5708));
  const Matrix3d half = so3::exp(Eigen::Vector3d(0.5, 0, 0));
  std::vector<RelativeRotation> edges = {{0, 1, I, 1},    {1, 2, I, 1},    {0, 2, quarter, 1},
                                         {3, 4, half, 1}, {4, 5, half, 1}, {3, 5, half * half, 1}};
  const AveragedRotations found = average_rotations(6, edges, {}, pool);
  EXPECT_EQ(found.pruned, (std::vector<std::uint8_t>{1, 1, 1, 0, 0, 0}));
  EXPECT_EQ(found.known, (std::vector<std::uint8_t>{0, 0, 0, 1, 1, 1}));
  EXPECT_LT((found.R_cw[5] * found.R_cw[3].transpose() - half * half).norm(), 1e-9);

  edges.resize(3);  // and where nothing is left, one image is
  const AveragedRotations none = average_rotations(4, edges, {}, pool);
  EXPECT_EQ(std::count(none.pruned.begin(), none.pruned.end(), 1), 3);
  EXPECT_EQ(std::count(none.known.begin(), none.known.end(), 1), 1);
  EXPECT_TRUE(std::isnan(none.angle[0]));
}

TEST(RotationAveraging, TakesThatOfTwoRotationsWhichAgrees) {
  linalg::ThreadPool pool(2);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Graph graph = row_of_images(60, 0.005, 0, seed);
    Random random(seed, 4);
    for (RelativeRotation& edge : graph.edges) {
      if (random.uniform() < 0.5) continue;
      edge.other = Matrix3d(test::random_rotation(random, 0.5) * edge.R_ji);
      if (random.uniform() < 0.5) std::swap(edge.R_ji, *edge.other);
    }
    const AveragedRotations found = average_rotations(60, graph.edges, {}, pool);
    EXPECT_LT(worst_error(graph, found), 0.06) << seed;
    EXPECT_EQ(std::count(found.pruned.begin(), found.pruned.end(), 1), 0) << seed;
    const auto given = given_rotations(graph.truth, graph.edges, {});
    EXPECT_EQ(std::count(given.pruned.begin(), given.pruned.end(), 1), 0) << seed;
  }
}

TEST(RotationAveraging, GivenRotationsStayAndJudge) {
  const Graph graph = row_of_images(30, 0.005, 0.2);
  const AveragedRotations found = given_rotations(graph.truth, graph.edges, {});
  for (std::size_t i = 0; i < 30; ++i) EXPECT_EQ(found.R_cw[i], graph.truth[i]) << i;
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    EXPECT_EQ(found.pruned[k] != 0, graph.wrong[k]) << k;
  }
  EXPECT_FALSE(found.tree);
  EXPECT_GT(found.before.largest, 0.4);
  EXPECT_LT(found.after.largest, 0.03);
}

// As many as a sparse factorisation is worth.
TEST(RotationAveraging, HasTheSameBitsForAnyNumberOfThreads) {
  const Graph graph = row_of_images(700, 0.01, 0.1);
  linalg::ThreadPool one(1), two(2);
  const auto a = average_rotations(700, graph.edges, {}, one);
  const auto b = average_rotations(700, graph.edges, {}, two);
  for (std::size_t i = 0; i < 700; ++i) EXPECT_EQ(a.R_cw[i], b.R_cw[i]) << i;
  EXPECT_LT(worst_error(graph, a), 0.3);
}

TEST(RotationAveraging, RefusesEdgesOfNoImages) {
  linalg::ThreadPool pool(1);
  const RelativeRotation outside = {0, 3, Matrix3d::Identity(), 1},
                         loop = {1, 1, Matrix3d::Identity(), 1};
  EXPECT_THROW(average_rotations(3, std::vector{outside}, {}, pool), std::invalid_argument);
  EXPECT_THROW(average_rotations(3, std::vector{loop}, {}, pool), std::invalid_argument);
  EXPECT_EQ(average_rotations(0, {}, {}, pool).R_cw.size(), 0U);
}

}  // namespace
}  // namespace raybundle::init
