#include <raybundle/solver/options.h>

#include <cmath>
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
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

template <class T>
struct Plain {
  using Type = T;
};
template <class T>
struct Plain<std::optional<T>> {
  using Type = T;
};

std::string message_of(const Options& options) {
  try {
    (void)resolve(options);
  } catch (const OptionError& error) {
    return error.what();
  }
  return "";
}

template <class Enum>
void check_names() {
  std::set<std::string> names;
  for (int i = 0; i < enum_count<Enum>; ++i) {
    const auto value = static_cast<Enum>(i);
    const std::string text = name(value);
    EXPECT_FALSE(text.empty());
    EXPECT_EQ(text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-"), std::string::npos);
    EXPECT_TRUE(names.insert(text).second) << text << " twice";
    EXPECT_EQ(parse_enum<Enum>("x", text), value);
  }
  try {
    parse_enum<Enum>("some-option", "nonsense");
    ADD_FAILURE() << "nonsense was taken";
  } catch (const OptionError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("some-option"), std::string::npos);
    EXPECT_NE(message.find("nonsense"), std::string::npos);
    for (const std::string& text : names) EXPECT_NE(message.find(text), std::string::npos) << text;
  }
  EXPECT_THROW(parse_enum<Enum>("x", ""), OptionError);
}

TEST(OptionNames, RoundTrip) {
  check_names<Method>();
  check_names<Elimination>();
  check_names<Linear>();
  check_names<Preconditioner>();
  check_names<DiagonalMatrix>();
  check_names<PoseUpdate>();
  check_names<Lens>();
}

// The counts are written by hand: the last value of each enumeration tells.
TEST(OptionNames, CountsReachTheLastValue) {
  EXPECT_EQ(static_cast<int>(Method::tnm) + 1, enum_count<Method>);
  EXPECT_EQ(static_cast<int>(Elimination::cameras) + 1, enum_count<Elimination>);
  EXPECT_EQ(static_cast<int>(Linear::implicit_pcg) + 1, enum_count<Linear>);
  EXPECT_EQ(static_cast<int>(Preconditioner::block_diag_s) + 1, enum_count<Preconditioner>);
  EXPECT_EQ(static_cast<int>(DiagonalMatrix::diag_h) + 1, enum_count<DiagonalMatrix>);
  EXPECT_EQ(static_cast<int>(PoseUpdate::se3) + 1, enum_count<PoseUpdate>);
  EXPECT_EQ(static_cast<int>(Lens::fixed) + 1, enum_count<Lens>);
}

TEST(OptionNames, AreThoseOthersRelyOn) {
  EXPECT_STREQ(name(Method::lm_cholesky), "lm-cholesky");
  EXPECT_STREQ(name(Method::tnm), "tnm");
  EXPECT_STREQ(name(Elimination::points), "points");
  EXPECT_STREQ(name(PoseUpdate::se3), "se3");
  EXPECT_STREQ(name(Lens::fixed), "fixed");
  for (int i = 0; i < enum_count<Method>; ++i) {
    EXPECT_EQ(traits(static_cast<Method>(i)).method, static_cast<Method>(i)) << "table order";
  }
}

TEST(OptionTable, NamesAreUniqueAndHelpIsThere) {
  Options options;
  std::set<std::string> names;
  visit_options(options, [&](const auto&, const OptionInfo& info) {
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_FALSE(std::string(info.help).empty()) << info.name;
    EXPECT_LE(info.low, info.high) << info.name;
  });
  for (const char* wanted :
       {"method", "elimination", "linear", "preconditioner", "damping-matrix", "scaling",
        "pose-update", "lens", "max-iterations", "time-limit", "function-tolerance",
        "gradient-tolerance", "parameter-tolerance", "threads"}) {
    EXPECT_EQ(names.count(wanted), 1U) << wanted;
  }
}

TEST(OptionTable, ReachesEveryMember) {
  // A member that is not visited could not be set, shown or checked. Everything is changed
  // through the table, and then nothing is as it was.
  Options options;
  visit_options(options, [](auto& value, const OptionInfo&) {
    using T = typename Plain<std::remove_cvref_t<decltype(value)>>::Type;
    if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(enum_count<T> - 1);
    } else {
      value = static_cast<T>(77);
    }
  });
  EXPECT_EQ(options.method, Method::tnm);
  EXPECT_EQ(options.elimination, Elimination::cameras);
  EXPECT_EQ(options.linear, Linear::implicit_pcg);
  EXPECT_EQ(options.preconditioner, Preconditioner::block_diag_s);
  EXPECT_EQ(options.damping_matrix, DiagonalMatrix::diag_h);
  EXPECT_EQ(options.scaling, DiagonalMatrix::diag_h);
  EXPECT_EQ(options.pose_update, PoseUpdate::se3);
  EXPECT_EQ(options.lens, Lens::fixed);
  for (const double value :
       {options.time_limit, options.function_tolerance, options.gradient_tolerance,
        options.parameter_tolerance, options.initial_damping, options.min_damping,
        options.max_damping, options.forcing.value_or(0)}) {
    EXPECT_EQ(value, 77);
  }
  for (const int value : {options.max_iterations, options.max_consecutive_failures,
                          options.max_inner_iterations.value_or(0), options.threads}) {
    EXPECT_EQ(value, 77);
  }
}

TEST(Resolve, FillsEveryChoiceThatHasAnEffect) {
  for (int i = 0; i < enum_count<Method>; ++i) {
    const Options effective = resolve({.method = static_cast<Method>(i)});
    EXPECT_TRUE(effective.elimination && effective.damping_matrix && effective.scaling);
    const bool inner = effective.method == Method::tnm;
    EXPECT_EQ(effective.preconditioner.has_value(), inner);
    EXPECT_EQ(effective.forcing.has_value(), inner);
    EXPECT_EQ(effective.max_inner_iterations.has_value(), inner);
  }
  EXPECT_EQ(resolve({}).elimination, Elimination::points);
  EXPECT_EQ(resolve({.elimination = Elimination::cameras}).elimination, Elimination::cameras);
  const Options tnm = resolve({.method = Method::tnm, .elimination = Elimination::none});
  EXPECT_NE(tnm.preconditioner, Preconditioner::diag_s) << "must fit the elimination";
  EXPECT_NE(tnm.preconditioner, Preconditioner::block_diag_s);
}

TEST(Resolve, TakesWhatItMade) {
  for (int i = 0; i < enum_count<Method>; ++i) {
    for (int e = 0; e < enum_count<Elimination>; ++e) {
      const Options once =
          resolve({.method = static_cast<Method>(i), .elimination = static_cast<Elimination>(e)});
      EXPECT_EQ(message_of(once), "");
    }
  }
}

// The effective options in a summary are those that repeat the solve.
TEST(Resolve, EffectiveOptionsRepeatTheSolve) {
  for (const Method method : {Method::lm_cholesky, Method::tnm}) {
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
  EXPECT_NE(message_of({.preconditioner = Preconditioner::b}).find("no effect"), std::string::npos);
  EXPECT_NE(message_of({.forcing = 0.1}).find("no effect"), std::string::npos);
  EXPECT_NE(message_of({.max_inner_iterations = 5}).find("no effect"), std::string::npos);
  EXPECT_NE(message_of({.linear = Linear::implicit_pcg}), "");
  EXPECT_NE(message_of({.method = Method::tnm, .linear = Linear::dense_cholesky}), "");
  EXPECT_NE(message_of({.method = Method::tnm, .linear = Linear::sparse_cholesky}), "");
  for (const auto schur : {Preconditioner::diag_s, Preconditioner::block_diag_s}) {
    EXPECT_NE(
        message_of(
            {.method = Method::tnm, .elimination = Elimination::none, .preconditioner = schur}),
        "");
    EXPECT_EQ(message_of({.method = Method::tnm, .preconditioner = schur}), "");
  }
}

TEST(Resolve, RefusesContradictingBounds) {
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
