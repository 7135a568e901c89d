// What one call of the bench changes of what its folder keeps.

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/solver/option_table.h>
#include <raybundle/tools/bench_call.h>

namespace raybundle::tools {
namespace {

using Words = std::vector<std::string>;

BenchArguments kept() {
  BenchArguments arguments;
  arguments.problems = {"p=x"};
  arguments.variants = {"v="};
  arguments.ceres_variants = {"c="};
  arguments.ceres = "driver";
  arguments.best = {"p=1", "q=2"};
  arguments.runs = 5;
  return arguments;
}

TEST(BenchCall, NothingGivenChangesNothing) {
  EXPECT_EQ(to_json(changed_by({}, kept())), to_json(kept()));
}

TEST(BenchCall, WhatIsGivenTakesThePlaceOfWhatWasKept) {
  BenchCall call;
  call.variants = {"w=--method tnm", "x="};
  call.best = {"q=3"};
  call.common = "";
  call.threads = 7;
  call.memory_limit = 12;
  const BenchArguments changed = changed_by(call, kept());
  EXPECT_EQ(changed.variants, call.variants);
  EXPECT_EQ(changed.best, (Words{"p=1", "q=3"}));
  EXPECT_EQ(changed.common, "");
  EXPECT_EQ(changed.threads, 7);
  EXPECT_EQ(changed.memory_limit, 12u);
  EXPECT_EQ(changed.runs, 5);
  EXPECT_EQ(changed.problems, kept().problems);
}

TEST(BenchCall, WithoutCeresNoneOfItsVariantsIsLeft) {
  BenchCall call;
  call.ceres = "none";
  EXPECT_EQ(changed_by(call, kept()).ceres, "");
  EXPECT_NO_THROW(make_plan(changed_by({.ceres = "none"}, {}), "out"));
  EXPECT_TRUE(changed_by(call, kept()).ceres_variants.empty());
  call.ceres_variants = {"d="};
  EXPECT_THROW(make_plan(changed_by(call, kept()), "out"), OptionError) << "contradict each other";
}

TEST(BenchCall, AReportTakesABestCostAndNothingElse) {
  EXPECT_NO_THROW(check_report_call({.best = {"p=1"}}));
  EXPECT_THROW(check_report_call({.problems = {"x"}}), OptionError);
  EXPECT_THROW(check_report_call({.scenes = {"s=x"}}), OptionError);
  EXPECT_THROW(check_report_call({.variants = {"v="}}), OptionError);
  EXPECT_THROW(check_report_call({.ceres_variants = {"v="}}), OptionError);
  EXPECT_THROW(check_report_call({.common = ""}), OptionError);
  EXPECT_THROW(check_report_call({.ceres = "none"}), OptionError);
  EXPECT_THROW(check_report_call({.runs = 3}), OptionError);
  EXPECT_THROW(check_report_call({.threads = 1}), OptionError);
  EXPECT_THROW(check_report_call({.time_limit = 300}), OptionError);
  EXPECT_THROW(check_report_call({.memory_limit = 0}), OptionError);
}

}  // namespace
}  // namespace raybundle::tools
