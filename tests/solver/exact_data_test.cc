// Scenes without noise: the observations can be met exactly, and then every method must say so.

#include <raybundle/solver/solve.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/alignment.h>
#include <raybundle/models/scenes/aerial.h>
#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/photos.h>
#include <raybundle/models/scenes/sphere.h>
#include <raybundle/models/scenes/street.h>

namespace raybundle {
namespace {

using Kind = std::pair<std::string, scenes::Scene>;

std::vector<Kind> kinds() {
  return {{"sphere", scenes::sphere_scene({.cameras = 8, .points = 150})},
          {"street", scenes::street_scene({.cameras = 12, .points = 300})},
          {"aerial", scenes::aerial_scene({.cameras = 9, .points = 250})},
          {"photos", scenes::photos_scene({.cameras = 8, .points = 200})}};
}

class ExactData : public ::testing::TestWithParam<Method> {};

TEST_P(ExactData, IsMetAndTheSolveConverges) {
  for (const auto& [kind, scene] : kinds()) {
    const Problem truth = scenes::add_noise(scene, {.pixel_noise = 0}).problem;
    Problem problem = scenes::perturb(truth);
    const Summary summary = solve(problem, {.method = GetParam(),
                                            .max_iterations = 200,
                                            .function_tolerance = 1e-16,
                                            .gradient_tolerance = 0,
                                            .parameter_tolerance = 0});
    ASSERT_TRUE(summary.usable()) << kind << ": " << summary.message;
    // Aerial views have little parallax: damping by the identity crawls along their valley.
    const bool crawls =
        kind == "aerial" && summary.options.damping_matrix == DiagonalMatrix::identity;
    if (crawls) continue;
    EXPECT_EQ(outcome(summary.termination), Outcome::converged) << kind << ": " << summary.message;
    EXPECT_LE(summary.final_cost, 1e-15 * summary.initial_cost) << kind;
    EXPECT_LE(compare_with_truth(problem, truth).camera_rmse, 1e-6) << kind;
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, ExactData,
                         ::testing::Values(Method::lm_cholesky, Method::tnm, Method::inm,
                                           Method::dinm, Method::adinm, Method::irls),
                         [](const auto& test) {
                           std::string text = name(test.param);
                           if (text == "lm-cholesky") text = "lm_cholesky";
                           return text;
                         });

// At the truth there is nothing to do, and that is no failure either.
TEST(ExactData, StartAtTheTruthIsConverged) {
  for (const auto& [kind, scene] : kinds()) {
    Problem problem = scenes::add_noise(scene, {.pixel_noise = 0}).problem;
    const Summary summary = solve(problem, {.gradient_tolerance = 0});
    EXPECT_EQ(summary.termination, Termination::function_tolerance) << kind;
    EXPECT_EQ(summary.iterations.size(), 1U) << kind;
    EXPECT_NE(summary.message.find("rounding"), std::string::npos) << summary.message;
  }
}

}  // namespace
}  // namespace raybundle
