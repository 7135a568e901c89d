// raybundle solve from end to end: log, solution, inputs of all kinds, bad ends.

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <zlib.h>
#include <nlohmann/json.hpp>

#include <raybundle/models/io/bal.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/models/statistics.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tests/support/bal_check.h>
#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tests/tools/process.h>
#include <raybundle/version.h>

namespace raybundle::tools {
namespace {

using nlohmann::json;
using test::Process;
using test::read_text;
using test::Result;
using test::run;
using test::TemporaryFolder;
using test::Words;
using test::write_text;

json read_log(const std::string& path) { return json::parse(read_text(path)); }

/// What `eval` prints with all digits.
double evaluated_cost(const std::string& path) {
  const std::string text = run({"eval", path}).output;
  const std::string label = "cost, all digits";
  const std::size_t at = text.find(label);
  return at == std::string::npos ? -1 : std::stod(text.substr(at + label.size()));
}

/// The cost of the last accepted step, as the engine judged it.
double last_accepted_cost(const json& log) {
  double cost = -1;
  for (const json& each : log["iterations"]) {
    if (each["accepted"] && each["iteration"] > 0) cost = each["candidate_cost"];
  }
  return cost;
}

class SolveCommand : public testing::Test {
 protected:
  SolveCommand() { io::write_bal(scene_, input_); }
  std::string path(const char* name) const { return (folder_ / name).string(); }

  TemporaryFolder folder_;
  Problem scene_ = scenes::street({.seed = 3, .cameras = 10, .points = 400});
  std::string input_ = path("scene.txt");
  std::string output_ = path("out.txt");
  std::string log_ = path("log.json");
};

TEST_F(SolveCommand, WithoutInputSolvesAStreet) {
  const Result result = run({"solve", "--seed", "5", "--log", log_});
  EXPECT_EQ(result.code, 0);
  const json log = read_log(log_);
  EXPECT_EQ(log["problem"]["source"], "street");
  EXPECT_EQ(log["problem"]["seed"], 5);
  EXPECT_LT(log["summary"]["final_cost"], 0.01 * log["summary"]["initial_cost"].get<double>());
  EXPECT_LT(log["summary"]["final_rmse"], 1.0);
  EXPECT_NE(result.output.find("converged"), std::string::npos);
}

TEST_F(SolveCommand, LogHasItsKeysAndTypes) {
  ASSERT_EQ(run({"solve", input_, "--log", log_, "--threads", "2"}).code, 0);
  const json log = read_log(log_);
  EXPECT_EQ(log["schema"], 1);
  EXPECT_EQ(log["version"], version);
  EXPECT_EQ(log["build"], build_description);
  EXPECT_EQ(log["problem"]["source"], input_);
  EXPECT_EQ(log["problem"]["cameras"], 10);
  EXPECT_EQ(log["problem"]["points"], 400);
  EXPECT_EQ(log["problem"]["observations"], scene_.observation_count());

  Options options;
  visit_options(options, [&](const auto&, const OptionInfo& info) {
    EXPECT_TRUE(log["options"].contains(info.name)) << info.name;
  });
  EXPECT_EQ(log["options"]["elimination"], "points");  // what took effect
  EXPECT_EQ(log["options"]["linear"], "dense-cholesky");
  EXPECT_EQ(log["options"]["threads"], 2);
  EXPECT_TRUE(log["options"]["time-limit"].is_null());  // none
  EXPECT_TRUE(log["options"]["min-radius"].is_null());  // does not apply

  const json& choice = log["summary"]["linear_choice"];
  EXPECT_EQ(choice["inner_iterations"], 10);
  ASSERT_EQ(choice["candidates"].size(), 4U);
  EXPECT_EQ(choice["candidates"][0]["linear"], "dense-cholesky");
  EXPECT_EQ(choice["candidates"][0]["lower_bound"], false);
  for (const char* key : {"work", "work_of_inner_iteration", "memory_bytes"}) {
    EXPECT_TRUE(choice["candidates"][0].at(key).is_number()) << key;
  }

  const json& iterations = log["iterations"];
  ASSERT_GT(iterations.size(), 2U);
  for (const json& each : iterations) {
    for (const char* key : {"cost", "gradient_norm", "step_norm", "damping", "radius", "seconds",
                            "gradient_max", "predicted_decrease", "relative_step"}) {
      EXPECT_TRUE(each.at(key).is_number()) << key;
    }
    EXPECT_TRUE(each.at("accepted").is_boolean());
    EXPECT_TRUE(each.at("inner_iterations").is_number_integer());
    EXPECT_TRUE(each.at("eliminated") == "points" || each["iteration"] == 0);
    EXPECT_TRUE(each.contains("rho") && each.contains("candidate_cost"));
  }
  EXPECT_EQ(iterations.front()["iteration"], 0);

  const json& summary = log["summary"];
  EXPECT_EQ(summary["initial_cost"], iterations.front()["cost"]);
  EXPECT_EQ(summary["final_cost"], iterations.back()["cost"]);
  EXPECT_EQ(summary["gradient_norm"], iterations.back()["gradient_norm"]);
  EXPECT_EQ(summary["iterations"], iterations.size() - 1);
  EXPECT_EQ(summary["accepted"].get<int>() + summary["rejected"].get<int>(), summary["iterations"]);
  EXPECT_EQ(summary["inner_iterations"], 0);
  EXPECT_EQ(summary["linear_solves"], summary["iterations"]);
  EXPECT_EQ(summary["threads"], 2);
  EXPECT_EQ(summary["initial_rmse"], reprojection_statistics(scene_).rmse);
  EXPECT_GT(summary["peak_rss_bytes"], 1'000'000);
  for (const char* key : {"termination", "message", "linear_solver"}) {
    EXPECT_TRUE(summary.at(key).is_string()) << key;
  }
  const json& seconds = summary["seconds"];
  for (const char* key : {"total", "setup", "residual", "jacobian", "linear", "io"}) {
    EXPECT_GE(seconds.at(key), 0.0) << key;
  }
  EXPECT_EQ(seconds["io"].get<double>(),
            seconds["read"].get<double>() + seconds["write"].get<double>());
}

TEST_F(SolveCommand, EigenvaluesAreShownOnRequest) {
  const Result plain = run({"solve", input_, "--log", log_});
  const json plain_log = read_log(log_);
  for (const json& each : plain_log["iterations"]) EXPECT_TRUE(each["diagnosis"].is_null());
  EXPECT_EQ(plain.errors.find("eigenvalues"), std::string::npos);
  const Result shown = run({"solve", input_, "--gauge", "fixed", "--diagnose", "--log", log_});
  EXPECT_NE(shown.errors.find("eigenvalues"), std::string::npos);
  const json log = read_log(log_);
  EXPECT_EQ(log["options"]["diagnose"], true);
  for (const json& each : log["iterations"]) {
    if (!each["accepted"]) continue;
    const json& points = each["diagnosis"]["points"];
    const json& reduced = each["diagnosis"]["reduced"];
    EXPECT_GT(points["smallest"], 0);
    EXPECT_GE(points["worst_condition"], 1);
    EXPECT_GT(points["largest"], points["smallest"]);
    EXPECT_GT(reduced["smallest"], 0);
    EXPECT_GT(reduced["largest"], reduced["smallest"]);
  }
  EXPECT_GT(log["summary"]["seconds"]["diagnosis"], 0);
}

TEST_F(SolveCommand, SolutionReadsBackWithTheCostOfTheLog) {
  for (const char* update : {"global", "local", "se3"}) {
    const Result result =
        run({"solve", input_, "-q", "-o", output_, "--log", log_, "--pose-update", update});
    ASSERT_EQ(result.code, 0);
    const json log = read_log(log_);
    EXPECT_EQ(evaluated_cost(output_), last_accepted_cost(log)) << update;
    const double final_cost = log["summary"]["final_cost"];
    EXPECT_EQ(evaluated_cost(output_), final_cost) << update;
    const Problem solution = io::read_bal(output_);
    EXPECT_EQ(reprojection_statistics(solution).rmse, log["summary"]["final_rmse"]);
    EXPECT_TRUE(test::same_bits(solution.observations, scene_.observations));
  }
  EXPECT_EQ(folder_.entry_count(), 3);
}

TEST_F(SolveCommand, StandardInputAndCompressedFilesAreReadTheSame) {
  ASSERT_EQ(run({"solve", input_, "-q", "-o", output_}).code, 0);
  const std::string expected = read_text(output_);
  ASSERT_EQ(run({"solve", "-", "-q", "-o", output_}, input_).code, 0);
  EXPECT_EQ(read_text(output_), expected);

  const std::string packed = path("scene.gz");
  const std::string text = read_text(input_);
  gzFile file = ::gzopen(packed.c_str(), "wb");
  ASSERT_EQ(::gzwrite(file, text.data(), static_cast<unsigned>(text.size())),
            static_cast<int>(text.size()));
  ::gzclose(file);
  ASSERT_EQ(run({"solve", packed, "-q", "-o", output_}).code, 0);
  EXPECT_EQ(read_text(output_), expected);
  ASSERT_EQ(run({"solve", "-", "-q", "-o", output_}, packed).code, 0);
  EXPECT_EQ(read_text(output_), expected);
}

TEST_F(SolveCommand, SolutionOrLogMayGoToStandardOutput) {
  ASSERT_EQ(run({"solve", input_, "-q", "-o", output_}).code, 0);
  const Result solution = run({"solve", input_, "-q", "-o", "-"});
  EXPECT_EQ(solution.output, read_text(output_));
  EXPECT_NE(solution.errors.find("converged"), std::string::npos);  // the report went there
  const Result log = run({"solve", input_, "-q", "--log", "-"});
  EXPECT_EQ(json::parse(log.output)["schema"], 1);
  EXPECT_NE(log.errors.find("converged"), std::string::npos);
}

TEST_F(SolveCommand, TheInputIsNeverReplaced) {
  const std::string before = read_text(input_);
  const std::string link = (folder_.path() / "link").string();
  std::filesystem::create_symlink(input_, link);
  for (const std::string& name : {input_, link}) {
    for (const char* option : {"-o", "--log"}) {
      const Result result = run({"solve", input_, "-q", option, name});
      EXPECT_EQ(result.code, 2);
      EXPECT_NE(result.errors.find("is the input"), std::string::npos) << result.errors;
    }
  }
  EXPECT_EQ(read_text(input_), before);
}

TEST_F(SolveCommand, LimitsAreUsable) {
  EXPECT_EQ(run({"solve", input_, "--max-iterations", "1", "--log", log_}).code, 0);
  EXPECT_EQ(read_log(log_)["summary"]["termination"], "max_iterations");
  EXPECT_EQ(run({"solve", input_, "--max-iterations", "0", "-o", output_}).code, 0);
  EXPECT_EQ(read_text(output_), read_text(input_));
  for (const char* none : {"0", "1e-9"}) {
    EXPECT_EQ(run({"solve", input_, "--time-limit", none, "--log", log_}).code, 0);
    EXPECT_EQ(read_log(log_)["summary"]["termination"], "time_limit");
  }
}

TEST_F(SolveCommand, NumericalFailureEndsWithCode4AndTheStateWritten) {
  // The point lies in the plane of its camera.
  write_text(input_, "1 1 1\n0 0 1 1\n0\n0\n0\n0\n0\n0\n1\n0\n0\n1\n1\n0\n");
  const Result result = run({"solve", input_, "-o", output_, "--log", log_});
  EXPECT_EQ(result.code, 4);
  EXPECT_EQ(read_text(output_), read_text(input_));
  const json summary = read_log(log_)["summary"];
  EXPECT_EQ(summary["termination"], "bad_start");
  EXPECT_TRUE(summary["final_cost"].is_null());  // not a finite number
}

TEST_F(SolveCommand, ALimitWithoutALowerCostEndsWithCode4) {
  io::write_bal(scenes::street({.seed = 3, .cameras = 6, .points = 120}), input_);
  ASSERT_EQ(run({"solve", input_, "--log", log_}).code, 0);
  const json log = read_log(log_);
  std::size_t k = 0;  // the first iteration that was rejected
  while (k < log["iterations"].size() && log["iterations"][k]["accepted"]) ++k;
  ASSERT_LT(k, log["iterations"].size());
  // Again, from where it started.
  ASSERT_EQ(run({"solve", input_, "-o", output_, "--max-iterations", std::to_string(k - 1)}).code,
            0);
  const std::string damping = log["iterations"][k]["damping"].dump();
  const Result result =
      run({"solve", output_, "-o", input_, "--max-iterations", "1", "--initial-damping", damping});
  EXPECT_EQ(result.code, 4) << result.output;
  EXPECT_EQ(read_text(input_), read_text(output_));  // the best state is the start
}

TEST_F(SolveCommand, TooLittleMemoryEndsWithCode5) {
  // Eliminating the camera leaves a dense matrix of 288 TB, which no address space holds.
  constexpr int points = 2'000'000;
  std::string text = "1 " + std::to_string(points) + " 1\n0 0 1 1\n0 0 0 0 0 0 1 0 0\n";
  for (int i = 0; i < points; ++i) text += "1 1 9\n";
  write_text(input_, text);
  const Result result = run(
      {"solve", input_, "-o", output_, "--elimination", "cameras", "--linear", "dense-cholesky"});
  EXPECT_EQ(result.code, 5) << result.errors;
  EXPECT_NE(result.errors.find("not enough memory"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(output_));
}

class Interrupted : public testing::TestWithParam<int> {};

TEST_P(Interrupted, EndsWithCode6AndTheBestStateWritten) {
  const TemporaryFolder folder;
  const std::string input = (folder / "in.txt").string();
  const std::string output = (folder / "out.txt").string();
  const std::string log = (folder / "log.json").string();
  io::write_bal(scenes::street({.cameras = 60, .points = 20000}), input);
  // Unpreconditioned and nearly exact: many iterations of many inner ones.
  Process process({"solve", input, "-o", output, "--log", log, "--method", "tnm",
                   "--preconditioner", "identity", "--forcing", "1e-12", "--max-inner-iterations",
                   "200", "--function-tolerance", "0", "--max-iterations", "100000"});
  ASSERT_TRUE(process.wait_for_error_text("\n    1 ")) << process.errors();
  process.signal(GetParam());
  EXPECT_EQ(process.wait(), 6) << process.errors();
  const json document = read_log(log);
  const json& summary = document["summary"];
  EXPECT_EQ(summary["termination"], "stopped");
  EXPECT_EQ(summary["message"],
            GetParam() == SIGINT ? "interrupted by SIGINT" : "interrupted by SIGTERM");
  EXPECT_LT(summary["final_cost"], summary["initial_cost"]);
  EXPECT_EQ(evaluated_cost(output), last_accepted_cost(document));
}

TEST_P(Interrupted, TheSecondTimeKillsAtOnce) {
  const TemporaryFolder folder;
  const std::string input = (folder / "in.txt").string();
  const std::string output = (folder / "out.txt").string();
  io::write_bal(scenes::street({.cameras = 20, .points = 2000}), input);
  // An iteration that does not end: a tolerance out of reach of rounding.
  Process process({"solve", input, "-o", output, "--method", "tnm", "--preconditioner", "identity",
                   "--forcing", "1e-300", "--max-inner-iterations", "1000000000"});
  ASSERT_TRUE(process.wait_for_error_text("\n    0 ")) << process.errors();
  process.signal(GetParam());
  ASSERT_TRUE(process.wait_for_error_text("once more")) << process.errors();
  process.signal(GetParam());
  EXPECT_EQ(process.wait(), 128 + GetParam());
  EXPECT_EQ(folder.entry_count(), 1);
}

INSTANTIATE_TEST_SUITE_P(Signals, Interrupted, testing::Values(SIGINT, SIGTERM),
                         [](const testing::TestParamInfo<int>& parameter) {
                           return parameter.param == SIGINT ? "SIGINT" : "SIGTERM";
                         });

}  // namespace
}  // namespace raybundle::tools
