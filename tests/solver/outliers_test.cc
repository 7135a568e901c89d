// Robust losses in the engine: outliers, graduated scales, and never a number that is none.

#include <raybundle/solver/solve.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include <raybundle/models/alignment.h>
#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/presets.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

struct Scene {
  Problem truth, start;
};

// The smallest scene of the thesis with one observation in ten anywhere in the image.
Scene scene(std::uint64_t seed, double outliers = 0.1) {
  const scenes::Preset preset = scenes::preset("sphere-10");
  Scene result;
  result.truth = scenes::add_noise(scenes::preset_scene(preset, seed),
                                   {.seed = seed, .pixel_noise = 1, .outlier_share = outliers})
                     .problem;
  scenes::StartOptions start = preset.start;
  start.seed = seed;
  result.start = scenes::perturb(result.truth, start);
  return result;
}

double point_error(const Scene& scene, const Options& options) {
  Problem problem = scene.start;
  const Summary summary = solve(problem, options);
  EXPECT_TRUE(std::isfinite(summary.final_cost));
  EXPECT_TRUE(summary.usable()) << summary.message;
  return compare_with_truth(problem, scene.truth).point_rmse;
}

TEST(Outliers, ALossKeepsThePointsNearTheTruth) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Scene given = scene(seed);
    const double plain = point_error(given, {.method = Method::dinm});
    EXPECT_LT(point_error(given, {.method = Method::irls}), 0.5 * plain) << seed;
    EXPECT_LT(point_error(given, {.method = Method::irls, .loss = Loss::truncated}), 0.5 * plain)
        << seed;
  }
}

// A loss that levels off at less than the residuals of a whole camera would never see it again.
TEST(Outliers, IrlsStartsWideEnoughForTheCameraThatStartsWorst) {
  Scene given = scene(3, 0);
  given.start.cameras[9 * 4 + 1] += 0.3;  // a turn by hundreds of pixels
  const auto error = [&](std::optional<double> start_scale) {
    Problem problem = given.start;
    const Summary summary = solve(
        problem, {.method = Method::irls, .loss_start_scale = start_scale, .max_iterations = 200});
    EXPECT_TRUE(summary.usable()) << summary.message;
    return compare_with_truth(problem, given.truth).camera_rmse;
  };
  EXPECT_GT(error(50), 20) << "twice the median of the others";
  EXPECT_LT(error(std::nullopt), 3);
}

TEST(Outliers, EveryLossWithEveryMethodEndsInNumbers) {
  const Scene given = scene(7, 0.3);
  for (const Method method :
       {Method::lm_cholesky, Method::tnm, Method::inm, Method::dinm, Method::adinm, Method::irls}) {
    for (const Loss loss : {Loss::none, Loss::huber, Loss::soft_l1, Loss::cauchy,
                            Loss::geman_mcclure, Loss::tukey, Loss::truncated}) {
      for (const LossScope scope : {LossScope::observation, LossScope::component}) {
        Problem problem = given.start;
        Options options = {.method = method, .loss = loss, .max_iterations = 15};
        if (loss != Loss::none) options.loss_scope = scope;
        const Summary summary = solve(problem, options);
        const std::string which = std::string(name(method)) + " " + name(loss);
        EXPECT_TRUE(std::isfinite(summary.final_cost)) << which;
        EXPECT_LE(summary.final_cost, summary.initial_cost) << which;
        for (const double x : problem.cameras) ASSERT_TRUE(std::isfinite(x)) << which;
        for (const double x : problem.points) ASSERT_TRUE(std::isfinite(x)) << which;
      }
    }
  }
}

// Beyond the cut of a truncated loss nothing pulls: such a point stays where it is.
TEST(Outliers, APointWhoseRowsAreAllCutDoesNotMove) {
  Problem start = test::small_problem({.seed = 5, .cameras = 5, .points = 30});
  constexpr std::size_t lost = 4;
  for (std::size_t k = 0; k < start.observation_point.size(); ++k) {
    if (start.observation_point[k] == lost) start.observations[2 * k] += 1e5;
  }
  for (const Method method : {Method::lm_cholesky, Method::inm, Method::dinm, Method::adinm}) {
    for (const Loss loss : {Loss::truncated, Loss::tukey}) {
      Problem problem = start;
      const Summary summary = solve(problem, {.method = method, .loss = loss, .loss_scale = 100});
      EXPECT_GT(summary.accepted, 0) << name(method);
      for (std::size_t i = 3 * lost; i < 3 * lost + 3; ++i) {
        EXPECT_EQ(problem.points[i], start.points[i]) << name(method) << " " << name(loss);
      }
    }
  }
}

TEST(GraduatedLoss, EndsAtItsFinalScaleAndReportsIt) {
  const Scene given = scene(3);
  Problem problem = given.start;
  const Summary summary = solve(
      problem,
      {.method = Method::irls, .loss_scale = 2, .loss_start_scale = 50, .max_iterations = 200});
  EXPECT_EQ(summary.iterations.front().loss_scale, 50);
  EXPECT_EQ(summary.iterations.back().loss_scale, 2);
  for (std::size_t k = 1; k < summary.iterations.size(); ++k) {
    const IterationRecord& now = summary.iterations[k];
    const IterationRecord& before = summary.iterations[k - 1];
    EXPECT_LE(now.loss_scale, before.loss_scale);
    if (now.loss_scale == before.loss_scale) {
      EXPECT_LE(now.cost, before.cost);
    }
  }
  EXPECT_EQ(outcome(summary.termination), Outcome::converged) << summary.message;
  EXPECT_LT(summary.final_cost, summary.initial_cost) << "both at the final scale";
  const Summary again = solve(problem, {.method = Method::irls, .loss_scale = 2});
  EXPECT_NEAR(again.initial_cost, summary.final_cost, 1e-12 * summary.final_cost);
}

// Whatever ends a solve, its costs are those of the final scale.
TEST(GraduatedLoss, ALimitEndsItAtAnyScale) {
  const Scene given = scene(3);
  Problem problem = given.start;
  const Summary summary =
      solve(problem,
            {.method = Method::irls, .loss_scale = 2, .loss_start_scale = 50, .max_iterations = 2});
  EXPECT_EQ(summary.termination, Termination::max_iterations);
  EXPECT_EQ(summary.iterations.back().loss_scale, 50);
  EXPECT_LT(summary.final_cost, summary.iterations.back().cost) << "a smaller scale costs less";
  const Summary again = solve(problem, {.method = Method::irls, .loss_scale = 2});
  EXPECT_NEAR(again.initial_cost, summary.final_cost, 1e-12 * summary.final_cost);
}

// However early the tests of convergence are satisfied while the scale is wide.
TEST(GraduatedLoss, LimitsAndObserversAreObeyedAtEveryScale) {
  const Scene given = scene(3);
  for (int most = 0; most <= 6; ++most) {
    Problem problem = given.start;
    const Summary summary = solve(problem, {.method = Method::irls,
                                            .max_iterations = most,
                                            .function_tolerance = 0.5,
                                            .gradient_tolerance = 1e9});
    EXPECT_LE(summary.iterations.size(), static_cast<std::size_t>(most) + 1);
    const bool final_scale = summary.iterations.back().loss_scale == 6;
    if (!final_scale) {
      EXPECT_EQ(summary.termination, Termination::max_iterations);
    }
    const auto once = [most](const IterationRecord& record) {
      return record.iteration == most ? Control::stop : Control::proceed;
    };
    problem = given.start;
    const Summary stopped =
        solve(problem, {.method = Method::irls, .function_tolerance = 0.5}, once);
    if (stopped.iterations.back().loss_scale == 6) continue;
    EXPECT_EQ(stopped.termination, Termination::stopped);
    EXPECT_EQ(stopped.iterations.size(), static_cast<std::size_t>(most) + 1);
  }
}

// Failures under a wide scale end that scale, and their damping does not survive it.
TEST(GraduatedLoss, ForgetsFailuresWithTheScale) {
  const Scene given = scene(3);
  Problem problem = given.start;
  const Summary summary = solve(
      problem, {.method = Method::irls, .max_consecutive_failures = 1, .initial_damping = 1e-12});
  for (std::size_t k = 1; k < summary.iterations.size(); ++k) {
    const IterationRecord& now = summary.iterations[k];
    if (now.loss_scale < summary.iterations[k - 1].loss_scale) {
      EXPECT_EQ(now.damping, 1e-12);
    }
  }
}

}  // namespace
}  // namespace raybundle
