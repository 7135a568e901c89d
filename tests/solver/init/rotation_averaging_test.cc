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
  EXPECT_LT(found.after.mean, 0.6 * found.tree.mean);
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

TEST(RotationAveraging, HasTheSameBitsForAnyNumberOfThreads) {
  const Graph graph = row_of_images(200, 0.01, 0.1);
  linalg::ThreadPool one(1), two(2);
  const auto a = average_rotations(200, graph.edges, {}, one);
  const auto b = average_rotations(200, graph.edges, {}, two);
  for (std::size_t i = 0; i < 200; ++i) EXPECT_EQ(a.R_cw[i], b.R_cw[i]) << i;
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
