// Positions of images whose rotations are known [Liu18, Theorem 2]: exact without noise, collinear
// motion included, and off in proportion to it.

#include <raybundle/solver/init/positions_linear.h>

#include <cstdint>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/alignment.h>
#include <raybundle/models/rotation.h>
#include <raybundle/models/scenes/aerial.h>
#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/solver/init/positions_nonlinear.h>
#include <raybundle/solver/init/view_graph.h>
#include <raybundle/tests/solver/init/true_graph.h>

namespace raybundle::init {
namespace {

struct Errors {
  double linear = 0, registered = 0;  // of the centres after alignment
};

// Of positions found with the rotations of `truth` from the observations of `seen`.
Errors position_errors(const Problem& truth, const Problem& seen, Loss loss) {
  linalg::ThreadPool pool(2);
  const Sightings sightings(seen, pool);
  const auto R_cw = camera_rotations(truth);
  const std::vector<std::uint8_t> known(R_cw.size(), 1);
  const ViewGraph graph = test::true_graph(truth, sightings, pool);
  const auto found = features(sightings, graph, R_cw, known, 10, pool);
  const LinearPositions linear = linear_positions(sightings, found.all, R_cw, known, 0, {}, pool);
  for (const std::uint8_t each : linear.known) EXPECT_EQ(each, 1);

  Problem problem = seen;
  for (std::size_t i = 0; i < R_cw.size(); ++i) {
    Eigen::Map<Eigen::Vector3d> rotation(problem.cameras.data() + 9 * i),
        t(problem.cameras.data() + 9 * i + 3);
    rotation = so3::log(R_cw[i]);
    t = -(R_cw[i] * linear.P[i]);
  }
  const auto error = [&] {
    const auto from = camera_centres(problem), to = camera_centres(truth);
    return root_mean_square(distances(align(from, to), from, to));
  };
  Errors result;
  result.linear = error();
  const Summary summary = register_positions(problem, {.loss = loss, .function_tolerance = 1e-9});
  EXPECT_TRUE(summary.usable()) << summary.message;
  result.registered = error();
  return result;
}

TEST(Positions, AreExactWithoutNoise) {
  for (const auto& scene :
       {scenes::street_scene({.cameras = 30, .points = 900}),
        scenes::street_scene({.cameras = 20, .points = 600, .collinear_share = 0.3}),
        scenes::aerial_scene({.cameras = 25, .points = 600})}) {
    const Errors errors = position_errors(scene.truth, scene.truth, Loss::none);
    EXPECT_LT(errors.linear, 1e-3);
    EXPECT_LT(errors.registered, 1e-6);
  }
}

TEST(Positions, AreOffInProportionToNoise) {
  const scenes::Scene scene = scenes::street_scene({.cameras = 20, .points = 1000});
  const auto registered = [&](double noise) {
    double sum = 0;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Problem seen = add_noise(scene, {.seed = seed, .pixel_noise = noise}).problem;
      sum += position_errors(scene.truth, seen, Loss::cauchy).registered;
    }
    return sum / 5;
  };
  const double of_one = registered(1), of_two = registered(2);
  EXPECT_LT(of_one, 0.1) << "steps";
  EXPECT_NEAR(of_two / of_one, 2, 0.3);
}

TEST(Positions, DoNotFollowWrongMatches) {
  const scenes::Scene scene = scenes::street_scene({.cameras = 20, .points = 1000});
  const Problem seen = add_noise(scene, {.pixel_noise = 0.5, .outlier_share = 0.05}).problem;
  EXPECT_LT(position_errors(scene.truth, seen, Loss::cauchy).registered, 0.1);
}

}  // namespace
}  // namespace raybundle::init
