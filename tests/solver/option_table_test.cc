// The table of options, and the names of their values.

#include <raybundle/solver/option_table.h>

#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <type_traits>

#include <gtest/gtest.h>

#include <raybundle/solver/methods.h>
#include <raybundle/tests/support/plain_type.h>

namespace raybundle {
namespace {

using test::Plain;

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
  check_names<ForcingRule>();
  check_names<Loss>();
  check_names<LossScope>();
  check_names<PointModel>();
  check_names<PointStart>();
  check_names<PointSteps>();
  check_names<ObjectiveKind>();
  check_names<RayWeight>();
  check_names<Gauge>();
}

// The counts are written by hand: the last value of each enumeration tells.
TEST(OptionNames, CountsReachTheLastValue) {
  EXPECT_EQ(static_cast<int>(Method::irls) + 1, enum_count<Method>);
  EXPECT_EQ(static_cast<int>(Elimination::cameras) + 1, enum_count<Elimination>);
  EXPECT_EQ(static_cast<int>(Linear::implicit_pcg) + 1, enum_count<Linear>);
  EXPECT_FALSE(iterates(Linear::cholmod));
  EXPECT_TRUE(iterates(Linear::explicit_pcg) && iterates(Linear::implicit_pcg));
  EXPECT_EQ(static_cast<int>(Preconditioner::adaptive) + 1, enum_count<Preconditioner>);
  EXPECT_EQ(static_cast<int>(DiagonalMatrix::held_h) + 1, enum_count<DiagonalMatrix>);
  EXPECT_EQ(static_cast<int>(PoseUpdate::se3) + 1, enum_count<PoseUpdate>);
  EXPECT_EQ(static_cast<int>(Lens::fixed) + 1, enum_count<Lens>);
  EXPECT_EQ(static_cast<int>(ForcingRule::nash_sofer) + 1, enum_count<ForcingRule>);
  EXPECT_EQ(static_cast<int>(Loss::truncated) + 1, enum_count<Loss>);
  EXPECT_EQ(static_cast<int>(LossScope::component) + 1, enum_count<LossScope>);
  EXPECT_EQ(static_cast<int>(PointModel::pmba) + 1, enum_count<PointModel>);
  EXPECT_EQ(static_cast<int>(PointStart::rays) + 1, enum_count<PointStart>);
  EXPECT_EQ(static_cast<int>(PointSteps::none) + 1, enum_count<PointSteps>);
  EXPECT_EQ(static_cast<int>(ObjectiveKind::ray) + 1, enum_count<ObjectiveKind>);
  EXPECT_EQ(static_cast<int>(RayWeight::unit) + 1, enum_count<RayWeight>);
  EXPECT_EQ(static_cast<int>(Gauge::fixed) + 1, enum_count<Gauge>);
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
        "gradient-tolerance", "parameter-tolerance", "threads", "memory-limit"}) {
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
  EXPECT_EQ(options.method, Method::irls);
  EXPECT_EQ(options.elimination, Elimination::cameras);
  EXPECT_EQ(options.linear, Linear::implicit_pcg);
  EXPECT_EQ(options.preconditioner, Preconditioner::adaptive);
  EXPECT_EQ(options.damping_matrix, DiagonalMatrix::held_h);
  EXPECT_EQ(options.scaling, DiagonalMatrix::held_h);
  EXPECT_EQ(options.pose_update, PoseUpdate::se3);
  EXPECT_EQ(options.lens, Lens::fixed);
  EXPECT_EQ(options.forcing_rule, ForcingRule::nash_sofer);
  EXPECT_EQ(options.point_start, PointStart::rays);
  EXPECT_EQ(options.loss, Loss::truncated);
  EXPECT_EQ(options.loss_scope, LossScope::component);
  EXPECT_TRUE(options.diagnose);
  for (const double value : {options.time_limit, options.memory_limit, options.function_tolerance,
                             options.gradient_tolerance, options.parameter_tolerance}) {
    EXPECT_EQ(value, 77);
  }
  for (const std::optional<double>& value :
       {options.initial_damping, options.min_damping, options.max_damping, options.initial_radius,
        options.min_radius, options.forcing, options.loss_scale, options.loss_start_scale,
        options.inc.rotation, options.inc.translation, options.inc.focal, options.inc.k1,
        options.inc.k2, options.inc.point, options.inc.parallax, options.inc.direction}) {
    EXPECT_EQ(value, 77);
  }
  for (const int value : {options.max_iterations, options.max_consecutive_failures,
                          options.max_inner_iterations.value_or(0), options.threads}) {
    EXPECT_EQ(value, 77);
  }
}

}  // namespace
}  // namespace raybundle
