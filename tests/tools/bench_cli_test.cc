// `raybundle bench`, as a user runs it.

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <raybundle/models/io/bal.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tests/tools/process.h>
#include <raybundle/tools/bench_process.h>

namespace raybundle::tools {
namespace {

using nlohmann::json;
using test::contains;
using test::Process;
using test::read_text;
using test::Result;
using test::run;
using test::Words;

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

class BenchCli : public testing::Test {
 protected:
  BenchCli() { io::write_bal(scenes::street({.seed = 3, .cameras = 10, .points = 300}), input_); }
  Words words(const Words& more) const {
    Words all = {"bench", "tiny=" + input_, "--ceres", "none", "--threads", "1", "-o", output_};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Words two_variants() const {
    return words({"--runs", "2", "--common", "--max-iterations 4", "--variant",
                  "chol=--method lm-cholesky", "--variant", "pcg=--method tnm"});
  }
  json results() const { return json::parse(read_text(output_ + "/results.json")); }

  test::TemporaryFolder folder_;
  std::string input_ = (folder_ / "tiny.txt").string();
  std::string output_ = (folder_ / "out").string();
};

TEST_F(BenchCli, RunsEveryVariantReportsAndResumes) {
  const Result first = run(two_variants());
  ASSERT_EQ(first.code, 0) << first.errors;
  EXPECT_TRUE(contains(first.errors, "[1/4] tiny  chol  run 1  ")) << first.errors;
  EXPECT_TRUE(contains(first.errors, "[2/4] tiny  pcg   run 1  "));
  EXPECT_TRUE(contains(first.errors, "[3/4] tiny  chol  run 2  "));

  const json report = results();
  ASSERT_EQ(report["runs"].size(), 4u);
  EXPECT_FALSE(report["machine"]["processor"].get<std::string>().empty());
  const double best = report["problems"][0]["best"];
  for (const json& each : report["runs"]) {
    EXPECT_EQ(each["status"], "ok");
    const json log =
        json::parse(read_text(output_ + "/runs/tiny/" + each["variant"].get<std::string>() + "/" +
                              std::to_string(each["run"].get<int>()) + ".json"));
    EXPECT_EQ(each["final_cost"], log["summary"]["final_cost"]);
    EXPECT_EQ(each["gradient_norm"], log["summary"]["gradient_norm"]);
    EXPECT_EQ(each["iterations"], 4);
    EXPECT_EQ(log["options"]["max-iterations"], 4);
    EXPECT_EQ(log["summary"]["threads"], 1);
    EXPECT_GE(each["final_cost"], best);
    EXPECT_GT(each["peak_bytes"], 1'000'000);
    EXPECT_GT(each["seconds_to_1e-1"], 0.0);
  }
  const std::string table = read_text(output_ + "/results.csv");
  EXPECT_EQ(count(table, "\n"), 5u);
  EXPECT_TRUE(contains(read_text(output_ + "/summary.md"), "| chol | ok |"));
  EXPECT_TRUE(contains(read_text(output_ + "/plots/profile_1e-01.gp"), "'pcg'"));

  // Nothing to do; the same from the folder alone; one log lost; another run asked for.
  const Result again = run(two_variants());
  EXPECT_EQ(again.code, 0);
  EXPECT_TRUE(contains(again.errors, "4 runs of an earlier call kept, 0 to be done"));
  EXPECT_EQ(results()["runs"], report["runs"]);
  std::filesystem::remove(output_ + "/runs/tiny/pcg/2.json");
  const Result resumed = run({"bench", "-o", output_});
  EXPECT_EQ(count(resumed.errors, "[1/1] tiny  pcg   run 2"), 1u) << resumed.errors;
  Words third = two_variants();
  third[9] = "3";
  EXPECT_EQ(count(run(third).errors, "  run 3  "), 2u);
  // A changed problem makes all of it void.
  io::write_bal(scenes::street({.seed = 4, .cameras = 10, .points = 300}), input_);
  EXPECT_FALSE(contains(run(two_variants()).errors, "kept"));
}

TEST_F(BenchCli, AReportAloneNeedsNoProblem) {
  ASSERT_EQ(run(two_variants()).code, 0);
  const std::string before = read_text(output_ + "/results.csv");
  std::filesystem::remove(input_);
  std::filesystem::remove(output_ + "/results.csv");
  EXPECT_EQ(run({"bench", "--only-report", "-o", output_}).code, 0);
  EXPECT_EQ(read_text(output_ + "/results.csv"), before);
}

TEST_F(BenchCli, AReportTakesABestCostAndRefusesWhatWouldNeedARun) {
  ASSERT_EQ(run(two_variants()).code, 0);
  const std::string plan = read_text(output_ + "/plan.json");
  const std::string before = read_text(output_ + "/results.json");
  const Words report = {"bench", "--only-report", "-o", output_};
  const auto with = [&report](const Words& more) {
    Words all = report;
    all.insert(all.end(), more.begin(), more.end());
    return run(all);
  };
  for (const Words& more :
       {Words{input_}, {"--runs", "3"}, {"--variant", "v="}, {"--best", "other=1"}}) {
    EXPECT_EQ(with(more).code, 2) << more[0];
  }
  EXPECT_TRUE(contains(with({"--runs", "3"}).errors, "--runs has no effect with --only-report"));
  EXPECT_EQ(read_text(output_ + "/plan.json"), plan);
  EXPECT_EQ(read_text(output_ + "/results.json"), before);
  EXPECT_EQ(with({"--best", "tiny=0.125"}).code, 0);
  EXPECT_EQ(results()["problems"][0]["best"], 0.125);
  EXPECT_EQ(results()["runs"].size(), 4u);
  EXPECT_EQ(run(report).code, 0);
  EXPECT_EQ(results()["problems"][0]["best"], 0.125) << "kept for later reports";
}

TEST_F(BenchCli, WhatIsGivenForAFolderChangesItsPlan) {
  ASSERT_EQ(run(two_variants()).code, 0);
  const Words again = {"bench", "-o", output_};
  const auto with = [&again](const Words& more) {
    Words all = again;
    all.insert(all.end(), more.begin(), more.end());
    return run(all);
  };
  const Result more_runs = with({"--runs", "3"});
  EXPECT_EQ(more_runs.code, 0) << more_runs.errors;
  EXPECT_TRUE(contains(more_runs.errors, "4 runs of an earlier call kept, 2 to be done"));
  const Result others = with({"--variant", "pcg=--method tnm", "--variant", "chol=--lens fixed"});
  EXPECT_EQ(others.code, 0) << others.errors;
  EXPECT_TRUE(contains(others.errors, "3 runs of an earlier call kept, 3 to be done"))
      << others.errors;
  // No run belongs to the plan any more: none may be reported, though the names are the same.
  EXPECT_EQ(with({"--common", "--bogus 1"}).code, 2);
  json plan = json::parse(read_text(output_ + "/plan.json"));
  EXPECT_EQ(plan["runs"], 3);
  plan["common"] = "--max-iterations 5";
  test::write_text(output_ + "/plan.json", plan.dump());
  EXPECT_EQ(with({"--only-report"}).code, 0);
  EXPECT_TRUE(results()["runs"].empty());
  const std::string summary = read_text(output_ + "/summary.md");
  EXPECT_TRUE(contains(summary, "### tiny\n\nNot run.\n")) << summary;
  EXPECT_TRUE(contains(summary, "No problem was run."));
}

TEST_F(BenchCli, ACallThatIsRefusedLeavesTheEarlierBench) {
  const std::string truth = (folder_ / "truth.txt").string();
  io::write_bal(scenes::street({.seed = 3, .cameras = 11, .points = 300}), truth);
  const std::string empty = (folder_ / "empty.txt").string();
  test::write_text(empty, "");
  const std::string scene = "s=sphere --cameras 5 --points 40";
  ASSERT_EQ(run(words({"--runs", "1", "--variant", "v=--max-iterations 2", "--scene", scene})).code,
            0);
  const std::string plan = read_text(output_ + "/plan.json");
  const auto refused = [&](const Words& more, int code, const std::string& why) {
    Words all = {"bench", "-o", output_};
    all.insert(all.end(), more.begin(), more.end());
    const Result result = run(all);
    EXPECT_EQ(result.code, code) << result.errors;
    EXPECT_TRUE(contains(result.errors, why)) << result.errors;
    EXPECT_EQ(read_text(output_ + "/plan.json"), plan);
  };
  // The first scene is good, and another than the one of this name that is there.
  refused({"--scene", "s=sphere --cameras 6 --points 40", "--scene", "x=foo"}, 2,
          "raybundle: --scene x: 'foo' is neither a kind (sphere, street, aerial, photos) nor a "
          "preset (sphere-10, ");
  refused({"--variant", "good=", "--variant", "bad=--bogus"}, 2, "variant bad: ");
  refused({"--variant", "bad=--max-iterations x"}, 2, "variant bad: --max-iterations: 'x'");
  refused({"--variant", "bad=--method lm-cholesky --forcing 0.1"}, 2, "variant bad: ");
  refused({"--variant", "bad=--log x"}, 2, "variant bad: ");
  refused({"--best", "other=1"}, 2, "other");
  refused({input_ + "x"}, 3, input_ + "x");
  refused({output_}, 3, "0 files cal* or intrinsic*");
  refused({empty}, 3, empty);
  refused({input_ + ":" + truth}, 3, truth + ":1: found 11 cameras and 300 points");

  const Result again = run({"bench", "-o", output_});
  EXPECT_EQ(again.code, 0) << again.errors;
  EXPECT_TRUE(contains(again.errors, "2 runs of an earlier call kept, 0 to be done"))
      << again.errors;
  EXPECT_FALSE(std::filesystem::exists(output_ + "/problems/new"));
}

// The driver's part is played by a script: Ceres need not be there.
TEST_F(BenchCli, TheRivalIsMeasuredLikeEveryVariant) {
  const std::string driver = (folder_ / "driver").string();
  test::write_text(driver, R"(#!/bin/sh
[ "$OPENBLAS_NUM_THREADS" = 1 ] || exit 3
case "$*" in *--fail*) echo "ceres_driver: cannot"; echo "  --fail"; exit 2;; esac
[ "$1" = ")" + input_ + R"(" ] && [ "$2" = --output ] || exit 4
echo '{"iterations": [
  {"iteration": 0, "cost": 1e9, "seconds": 0.5, "gradient_norm": 7},
  {"iteration": 1, "cost": 0.5, "seconds": 0.75, "gradient_norm": 3}],
  "summary": {"initial_cost": 1e9, "final_cost": 0.5, "termination": "well, \"done\"",
              "seconds": {"total": 0.8}}}' > "$3"
)");
  std::filesystem::permissions(driver, std::filesystem::perms::owner_all);
  const Result result = run({"bench", "tiny=" + input_, "--ceres", driver, "--ceres-variant",
                             "good=--x 1", "--ceres-variant", "bad=--fail 1", "--variant",
                             "ours=--max-iterations 1", "--runs", "1", "-o", output_});
  EXPECT_EQ(result.code, 1);
  EXPECT_TRUE(contains(result.errors, "refused: ceres_driver: cannot\n")) << result.errors;
  const json report = results();
  EXPECT_EQ(report["problems"][0]["best"], 0.5);
  ASSERT_EQ(report["runs"].size(), 3u);
  EXPECT_EQ(report["runs"][2]["status"], "refused");
  EXPECT_TRUE(report["runs"][2]["final_cost"].is_null());
  EXPECT_TRUE(contains(result.errors, "raybundle: 1 run could not be carried out"));
  const json& good = report["runs"][1];
  EXPECT_EQ(good["variant"], "good");
  EXPECT_EQ(good["status"], "ok");
  EXPECT_EQ(good["final_cost"], 0.5);
  EXPECT_EQ(good["gradient_norm"], 3);
  EXPECT_EQ(good["iterations"], 1);
  EXPECT_EQ(good["seconds"], 0.8);
  EXPECT_EQ(good["seconds_to_1e-3"], 0.75);
  EXPECT_TRUE(contains(read_text(output_ + "/results.csv"), "\"well, \"\"done\"\"\""));
}

TEST_F(BenchCli, MemoryLimitIsAResult) {
  if (!limits_memory()) GTEST_SKIP() << "not with a sanitizer";
  const Result result = run(words({"--runs", "1", "--variant", "a=", "--memory-limit", "1MB"}));
  EXPECT_EQ(result.code, 0) << result.errors;
  EXPECT_EQ(results()["runs"][0]["status"], "no-memory");
}

TEST_F(BenchCli, AnInterruptKeepsWhatIsDone) {
  // A variant that goes on for long, after one that does not.
  io::write_bal(scenes::street({.seed = 3, .cameras = 60, .points = 20'000}), input_);
  Process bench(words({"--runs", "1", "--common",
                       "--max-iterations 1 --function-tolerance 0 --gradient-tolerance 0 "
                       "--parameter-tolerance 0",
                       "--variant", "short=", "--variant",
                       "long=--method tnm --max-iterations 100000 --forcing 1e-12 "
                       "--preconditioner identity --max-inner-iterations 100000 "
                       "--max-consecutive-failures 1000000"}));
  ASSERT_TRUE(bench.wait_for_error_text("[1/2]"));
  bench.signal(SIGINT);
  EXPECT_EQ(bench.wait(), 6) << bench.errors();
  EXPECT_TRUE(contains(bench.errors(), "interrupted"));
  EXPECT_EQ(results()["runs"].size(), 1u);
  EXPECT_FALSE(std::filesystem::exists(output_ + "/runs/tiny/long/1.run.json"));
}

TEST_F(BenchCli, SaysWhatIsMissing) {
  EXPECT_EQ(run({"bench", "-o", output_}).code, 2);
  EXPECT_EQ(run({"bench", input_}).code, 2);
  const Result missing = run({"bench", "none=" + input_ + "x", "--ceres", "none", "-o", output_});
  EXPECT_EQ(missing.code, 3) << missing.errors;
  EXPECT_TRUE(contains(missing.errors, input_ + "x"));
}

}  // namespace
}  // namespace raybundle::tools
