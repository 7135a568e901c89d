#include <raybundle/solver/options.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <type_traits>

#include <gtest/gtest.h>

#include <raybundle/models/problem.h>
#include <raybundle/solver/methods.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/solver/solve.h>
#include <raybundle/tests/support/plain_type.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

using test::Plain;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

std::string message_of(const Options& options) {
  try {
    (void)resolve(options);
  } catch (const OptionError& error) {
    return error.what();
  }
  return "";
}

TEST(Resolve, FillsEveryChoiceThatHasAnEffect) {
  for (int i = 0; i < enum_count<Method>; ++i) {
    const Options effective = resolve({.method = static_cast<Method>(i)});
    const MethodTraits& method = traits(effective.method);
    EXPECT_TRUE(effective.loss);
    EXPECT_EQ(effective.scaling.has_value(), method.bounded || method.inner == InnerSolve::pcg);
    EXPECT_EQ(effective.gauge, method.inner == InnerSolve::dogleg ? Gauge::fixed : Gauge::free);
    EXPECT_EQ(effective.lens, Lens::free);
    EXPECT_NE(effective.elimination.has_value(), method.adaptive);
    EXPECT_EQ(effective.damping_matrix.has_value(), method.damped);
    EXPECT_EQ(effective.initial_damping.has_value(), method.damped);
    EXPECT_EQ(effective.min_radius.has_value(), method.bounded);
    EXPECT_EQ(effective.loss_scale.has_value(), effective.loss != Loss::none);
    EXPECT_EQ(effective.inc.focal.has_value(), effective.scaling == DiagonalMatrix::inc);
    const bool inner = has_inner_iterations(method);
    EXPECT_EQ(effective.preconditioner.has_value(), inner);
    EXPECT_EQ(effective.forcing.has_value(), inner);
    EXPECT_EQ(effective.max_inner_iterations.has_value(), inner);
  }
  EXPECT_EQ(resolve({}).point_start, PointStart::problem);
  EXPECT_EQ(resolve({.point_start = PointStart::rays}).point_start, PointStart::rays);
  const Options anchored = resolve({.method = Method::dinm, .points = PointModel::idp});
  EXPECT_TRUE(anchored.inc.direction && !anchored.inc.parallax && !anchored.inc.point);
  const Options undamped = resolve({.method = Method::inm, .points = PointModel::pmba});
  EXPECT_EQ(undamped.inc.parallax, 1e-8) << "inm bounds the blocks of the points too";
  EXPECT_EQ(undamped.inc.rotation, 1e-8);
  EXPECT_EQ(undamped.inc.translation, 1e-8);
  EXPECT_EQ(undamped.inc.direction, 1e-9);
  EXPECT_EQ(resolve({.method = Method::inm, .points = PointModel::idp}).inc.parallax, 1e-9);
  const Options coordinates = resolve({.method = Method::dinm});
  EXPECT_TRUE(!coordinates.inc.parallax && !coordinates.inc.direction && coordinates.inc.point);
  EXPECT_EQ(resolve({}).elimination, Elimination::points);
  EXPECT_EQ(resolve({.elimination = Elimination::cameras}).elimination, Elimination::cameras);
  const Options tnm = resolve({.method = Method::tnm, .elimination = Elimination::none});
  EXPECT_NE(tnm.preconditioner, Preconditioner::diag_s) << "must fit the elimination";
  EXPECT_EQ(tnm.preconditioner, Preconditioner::b);
  EXPECT_EQ(resolve({.method = Method::tnm, .elimination = Elimination::cameras}).preconditioner,
            Preconditioner::block_diag_s);
}

/// The number after "auto: " that ends a help text, alone or before a comma and an exception.
std::optional<double> promised(const std::string& help) {
  const std::size_t at = help.find("auto: ");
  if (at == std::string::npos) return std::nullopt;
  const std::string rest = help.substr(at + 6);
  char* end = nullptr;
  const double value = std::strtod(rest.c_str(), &end);
  return end != rest.c_str() && (*end == '\0' || *end == ',') ? std::optional(value) : std::nullopt;
}

TEST(Resolve, RaysHaveFixedLensesAndAWeight) {
  const Options rays = resolve({.objective = ObjectiveKind::ray});
  EXPECT_EQ(rays.lens, Lens::fixed);
  EXPECT_EQ(rays.ray_weight, RayWeight::pixel);
  EXPECT_EQ(message_of(rays), "");
  EXPECT_NE(message_of({.lens = Lens::free, .objective = ObjectiveKind::ray}), "");
  EXPECT_NE(message_of({.ray_weight = RayWeight::unit}), "") << "of pixels";
}

TEST(Resolve, AnchoredPointsKeepTheCameras) {
  for (const PointModel points : {PointModel::idp, PointModel::pba, PointModel::pmba}) {
    EXPECT_EQ(message_of({.points = points}), "");
    EXPECT_NE(message_of({.elimination = Elimination::cameras, .points = points}), "");
    EXPECT_NE(message_of({.method = Method::adinm, .points = points}), "");
  }
}

TEST(Resolve, FillsWhatTheHelpPromises) {
  std::set<std::string> seen;
  for (int i = 0; i < enum_count<Method>; ++i) {
    const Options options = resolve({.method = static_cast<Method>(i)});
    visit_options(options, [&](const auto& value, const OptionInfo& info) {
      using T = typename Plain<std::remove_cvref_t<decltype(value)>>::Type;
      if constexpr (!std::is_enum_v<T> &&
                    !std::is_same_v<std::remove_cvref_t<decltype(value)>, T>) {
        const auto number = promised(info.help);
        if (!number || !value) return;
        EXPECT_EQ(static_cast<double>(*value), *number) << info.name;
        seen.insert(info.name);
      }
    });
    const bool lm = options.method == Method::automatic || options.method == Method::lm_cholesky ||
                    options.method == Method::tnm;
    if (traits(options.method).damped) {
      const bool chooses = options.method == Method::automatic;
      const auto of_h = chooses ? DiagonalMatrix::held_h : DiagonalMatrix::diag_h;
      EXPECT_EQ(options.damping_matrix, lm ? of_h : DiagonalMatrix::identity);
      EXPECT_EQ(options.initial_damping, lm ? 1e-4 : 1);
    }
    if (traits(options.method).inner != InnerSolve::pcg) continue;
    EXPECT_EQ(options.preconditioner, lm ? Preconditioner::adaptive : Preconditioner::block_diag_s);
    EXPECT_EQ(options.scaling, lm ? DiagonalMatrix::identity : DiagonalMatrix::inc);
  }
  for (const char* name :
       {"min-damping", "max-damping", "min-radius", "max-inner-iterations", "forcing",
        "inc-rotation", "inc-translation", "inc-focal", "inc-k1", "inc-k2", "inc-point"}) {
    EXPECT_EQ(seen.count(name), 1U) << name;
  }
}

TEST(Resolve, TakesWhatItMade) {
  for (int i = 0; i < enum_count<Method>; ++i) {
    for (int e = 0; e < enum_count<Elimination>; ++e) {
      Options options = {.method = static_cast<Method>(i)};
      if (!traits(options.method).adaptive) options.elimination = static_cast<Elimination>(e);
      const Options once = resolve(options);
      EXPECT_EQ(message_of(once), "");
    }
  }
}

// The effective options in a summary are those that repeat the solve.
TEST(Resolve, EffectiveOptionsRepeatTheSolve) {
  for (const Method method :
       {Method::lm_cholesky, Method::tnm, Method::inm, Method::adinm, Method::irls}) {
    Problem first = test::small_problem(), second = first;
    const Summary summary = solve(first, {.method = method, .max_iterations = 3});
    const Summary again = solve(second, summary.options);
    EXPECT_EQ(first.cameras, second.cameras);
    EXPECT_EQ(summary.final_cost, again.final_cost);
  }
}

TEST(Resolve, RefusesValuesOutOfRangeByName) {
  const auto refused = [](const Options& options, const std::string& name) {
    const std::string message = message_of(options);
    EXPECT_NE(message.find("--" + name), std::string::npos) << name << ": '" << message << "'";
  };
  for (const double value : {-1e-9, 1.5, nan, inf}) {
    refused({.function_tolerance = value}, "function-tolerance");
    refused({.parameter_tolerance = value}, "parameter-tolerance");
    refused({.method = Method::tnm, .forcing = value}, "forcing");
  }
  for (const double value : {-1.0, nan}) {
    refused({.gradient_tolerance = value}, "gradient-tolerance");
    refused({.time_limit = value}, "time-limit");
    refused({.initial_damping = value}, "initial-damping");
    refused({.min_damping = value}, "min-damping");
    refused({.max_damping = value}, "max-damping");
  }
  refused({.max_iterations = -1}, "max-iterations");
  refused({.max_consecutive_failures = 0}, "max-consecutive-failures");
  refused({.method = Method::tnm, .max_inner_iterations = 0}, "max-inner-iterations");
  refused({.threads = -1}, "threads");
  EXPECT_EQ(message_of({.max_iterations = 0, .time_limit = 0}), "");
}

TEST(Resolve, RefusesWhatHasNoEffect) {
  for (const Options& exact : {Options{.preconditioner = Preconditioner::b},
                               Options{.forcing = 0.1}, Options{.max_inner_iterations = 5}}) {
    Options options = exact;
    options.method = Method::lm_cholesky;
    EXPECT_NE(message_of(options).find("no effect"), std::string::npos);
  }
  EXPECT_NE(message_of({.method = Method::lm_cholesky, .linear = Linear::implicit_pcg}), "");
  EXPECT_NE(message_of({.method = Method::tnm, .linear = Linear::dense_cholesky}), "");
  EXPECT_NE(message_of({.method = Method::lm_cholesky, .linear = Linear::explicit_pcg}), "");
  for (const Linear exact : {Linear::sparse_cholesky, Linear::cholmod}) {
    EXPECT_NE(message_of({.method = Method::tnm, .linear = exact}), "");
  }
  EXPECT_EQ(message_of({.method = Method::dinm, .linear = Linear::explicit_pcg}), "");
  EXPECT_NE(message_of({.method = Method::adinm, .linear = Linear::explicit_pcg}), "");
  for (const auto schur : {Preconditioner::diag_s, Preconditioner::block_diag_s}) {
    EXPECT_NE(
        message_of(
            {.method = Method::tnm, .elimination = Elimination::none, .preconditioner = schur}),
        "");
    EXPECT_EQ(message_of({.method = Method::tnm, .preconditioner = schur}), "");
  }
}

TEST(Resolve, ClustersAreOfCamerasThatAreKept) {
  for (const auto clusters : {Preconditioner::two_level, Preconditioner::adaptive}) {
    EXPECT_EQ(message_of({.method = Method::dinm, .preconditioner = clusters}), "");
    for (const auto& without : {Options{.method = Method::tnm, .elimination = Elimination::none},
                                Options{.method = Method::tnm, .elimination = Elimination::cameras},
                                Options{.method = Method::adinm}}) {
      Options options = without;
      options.preconditioner = clusters;
      EXPECT_NE(message_of(options).find("--preconditioner"), std::string::npos);
    }
  }
}

TEST(Resolve, AutoBecomesTheMethodThatHasWhatIsAskedFor) {
  const auto method = [](const Options& options) { return resolve(options).method; };
  EXPECT_EQ(method({}), Method::automatic);
  EXPECT_EQ(method({.linear = Linear::implicit_pcg}), Method::tnm);
  EXPECT_EQ(method({.preconditioner = Preconditioner::b}), Method::tnm);
  EXPECT_EQ(method({.scaling = DiagonalMatrix::inc}), Method::tnm);
  EXPECT_EQ(method({.max_inner_iterations = 5}), Method::tnm);
  EXPECT_EQ(method({.linear = Linear::explicit_pcg}), Method::tnm);
  EXPECT_EQ(method({.linear = Linear::sparse_cholesky}), Method::lm_cholesky);
  EXPECT_EQ(method({.linear = Linear::cholmod}), Method::lm_cholesky);
  EXPECT_EQ(method({.elimination = Elimination::none}), Method::lm_cholesky);
  EXPECT_EQ(method({.elimination = Elimination::cameras}), Method::tnm);
  EXPECT_EQ(method({.elimination = Elimination::points}), Method::automatic);
  EXPECT_EQ(method({.damping_matrix = DiagonalMatrix::identity}), Method::automatic);
  const std::string both =
      message_of({.linear = Linear::dense_cholesky, .preconditioner = Preconditioner::b});
  EXPECT_NE(both.find("leave out one or the other"), std::string::npos) << both;
  // What took effect may be asked for again.
  Options effective = resolve({});
  EXPECT_EQ(resolve(effective).method, Method::automatic);
  effective.linear = Linear::dense_cholesky;
  EXPECT_EQ(resolve(effective).method, Method::lm_cholesky);
}

TEST(Resolve, RefusesWhatTheMethodDoesNotHave) {
  const auto refused = [](const Options& options, const std::string& name) {
    const std::string message = message_of(options);
    EXPECT_NE(message.find("--" + name), std::string::npos) << name << ": '" << message << "'";
  };
  refused({.method = Method::inm, .damping_matrix = DiagonalMatrix::identity}, "damping-matrix");
  refused({.method = Method::inm, .initial_damping = 1}, "initial-damping");
  refused({.method = Method::inm, .min_damping = 1}, "min-damping");
  refused({.method = Method::inm, .max_damping = 1}, "max-damping");
  refused({.method = Method::tnm, .initial_radius = 1}, "initial-radius");
  refused({.method = Method::lm_cholesky, .min_radius = 1}, "min-radius");
  refused({.method = Method::adinm, .elimination = Elimination::points}, "elimination");
  refused({.method = Method::lm_cholesky, .forcing_rule = ForcingRule::constant}, "forcing-rule");
  refused({.method = Method::lm_cholesky, .scaling = DiagonalMatrix::diag_h}, "scaling");
  refused({.damping_matrix = DiagonalMatrix::held_h, .points = PointModel::pmba}, "damping-matrix");
  refused({.loss_scale = 2}, "loss-scale");
  refused({.loss_scope = LossScope::component}, "loss-scope");
  refused({.loss_start_scale = 9}, "loss-start-scale");
  refused({.method = Method::irls, .loss = Loss::none, .loss_scale = 2}, "loss-scale");
  refused({.inc = {.rotation = 1e-8}}, "inc-rotation");
  refused({.method = Method::dinm, .lens = Lens::fixed, .inc = {.k1 = 1e-8}}, "inc-k1");
  EXPECT_EQ(message_of({.method = Method::dinm, .inc = {.rotation = 1e-8}}), "");
  refused({.method = Method::dinm, .inc = {.parallax = 1e-8}}, "inc-parallax");
  refused({.method = Method::dinm, .points = PointModel::pmba, .inc = {.point = 1e-8}},
          "inc-point");
  refused({.method = Method::dinm, .points = PointModel::pmba, .inc = {.parallax = 1e-8}},
          "inc-parallax");
  EXPECT_EQ(message_of({.method = Method::dinm,
                        .elimination = Elimination::none,
                        .points = PointModel::pmba,
                        .inc = {.parallax = 1e-8}}),
            "");
  EXPECT_EQ(message_of({.damping_matrix = DiagonalMatrix::inc, .inc = {.k1 = 1e-8}}), "");
  EXPECT_EQ(message_of({.method = Method::irls, .loss_scale = 2, .loss_start_scale = 9}), "");
  EXPECT_EQ(message_of({.loss = Loss::cauchy, .loss_scale = 2}), "") << "any method takes a loss";
}

TEST(Resolve, RefusesContradictingBounds) {
  EXPECT_NE(message_of({.method = Method::inm, .initial_radius = 1, .min_radius = 2}), "");
  EXPECT_EQ(message_of({.method = Method::inm, .initial_radius = 1e-40}), "")
      << "the least follows";
  EXPECT_NE(message_of({.initial_damping = 1e-3, .min_damping = 1}), "");
  EXPECT_EQ(message_of({.initial_damping = 0}), "") << "the least follows";
  EXPECT_NE(message_of({.loss = Loss::huber, .loss_scale = 2, .loss_start_scale = 1}), "");
  EXPECT_NE(message_of({.initial_damping = 1, .min_damping = 10, .max_damping = 5}), "");
}

TEST(Solve, PassesRefusalsOnAndLeavesTheProblemAlone) {
  Problem problem = test::small_problem();
  const Problem before = problem;
  EXPECT_THROW((void)solve(problem, {.max_iterations = -1}), OptionError);
  EXPECT_EQ(problem.cameras, before.cameras);
  EXPECT_EQ(problem.points, before.points);
}

}  // namespace
}  // namespace raybundle
