// The program as its users meet it: options, exit codes, where things are written.

#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <raybundle/models/io/bal.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tests/support/bal_check.h>
#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tests/tools/process.h>
#include <raybundle/version.h>

namespace raybundle::tools {
namespace {

using test::contains;
using test::Process;
using test::read_text;
using test::Result;
using test::run;
using test::TemporaryFolder;
using test::Words;
using test::write_text;

/// Where the program shows a table of iterations, it has started to solve.
bool solved(const Result& result) { return contains(result.errors, "|gradient|"); }

/// A small scene in a file.
class WithScene : public testing::Test {
 protected:
  WithScene() { io::write_bal(scene_, input_); }

  TemporaryFolder folder_;
  Problem scene_ = scenes::street({.seed = 3, .cameras = 10, .points = 400});
  std::string input_ = (folder_ / "scene.txt").string();
};

std::string joined(const std::string& text) {
  std::istringstream words(text);
  std::string all, word;
  while (words >> word) all += (all.empty() ? "" : " ") + word;
  return all;
}

TEST(Cli, HelpListsEveryOptionWithItsDefault) {
  const Result help = run({"solve", "-h"});
  EXPECT_EQ(help.code, 0);
  EXPECT_EQ(help.errors, "");
  Options options;
  visit_options(options, [&](const auto&, const OptionInfo& info) {
    const std::size_t at = help.output.find(std::string("--") + info.name + " ");
    ASSERT_NE(at, std::string::npos) << info.name;
    // A long line is broken between words.
    const std::size_t next = help.output.find("\n  --", at);
    const std::string entry = joined(help.output.substr(at, next - at));
    EXPECT_TRUE(contains(entry, joined(info.help) + " [")) << entry;
    EXPECT_TRUE(contains(entry, "]")) << entry;
  });
  EXPECT_TRUE(contains(help.output, "lm-cholesky|tnm"));
  EXPECT_TRUE(contains(help.output, "[auto]"));
  EXPECT_TRUE(contains(help.output, "[inf]"));
  for (const char* command : {"info", "eval", "version"}) {
    EXPECT_EQ(run({command, "-h"}).code, 0) << command;
    EXPECT_TRUE(contains(run({"-h"}).output, command));
  }
  EXPECT_EQ(run({"--version"}).output, std::string(version) + "\n");
}

TEST_F(WithScene, MistakesInOptionsEndWithCode2AndAWordAboutThem) {
  struct Mistake {
    Words arguments;
    std::string complaint;
  };
  const std::vector<Mistake> mistakes = {
      {{}, "A subcommand is required"},
      {{"sovle"}, "'sovle' is neither a subcommand nor an option"},
      {{"solve", input_, "--metod", "tnm"}, "--metod"},
      {{"solve", input_, "extra"}, "extra"},
      {{"solve", input_, "--method", "ransac"}, "'ransac' is none of auto, lm-cholesky, tnm"},
      {{"solve", input_, "--method"}, "--method"},
      {{"solve", input_, "--loss", "l2"}, "tukey, truncated, auto"},
      {{"solve", input_, "--loss-scale", "two"}, "to 1e+100, or auto"},
      {{"solve", input_, "--threads", "two"}, "'two' is not a whole number from 0 to 1024"},
      {{"solve", input_, "--threads", "2.0"}, "'2.0'"},
      {{"solve", input_, "--threads", "-1"}, "'-1'"},
      {{"solve", input_, "--threads", ""}, "''"},
      {{"solve", input_, "--max-iterations", "99999999999"}, "99999999999"},
      {{"solve", input_, "--time-limit", "5s"}, "'5s' is not a number from 0 to inf"},
      {{"solve", input_, "--time-limit", "nan"}, "nan"},
      {{"solve", input_, "--function-tolerance", "inf"}, "from 0 to 1"},
      {{"solve", input_, "--method", "lm-cholesky", "--forcing", "0.5"}, "has no inner iterations"},
      {{"solve", input_, "--linear", "dense-cholesky", "--preconditioner", "b"},
       "leave out one or the other"},
      {{"solve", input_, "--seed", "1"}, "--seed has no effect"},
      {{"solve", "--seed", "-1"}, "'-1'"},
      {{"solve", input_, "-o", "-", "--log", "-"}, "are the same"},
      {{"solve", input_, "-o", "x.txt", "--log", "./x.txt"}, "are the same"},
      {{"solve", input_, "-q", "--method", "tnm", "--method", "tnm"}, "--method"},
      {{"solve", input_, "-o", "x.txt.gz"}, "would not be compressed"},
      {{"solve", ""}, "name is empty"},
      {{"solve", input_, "-o", ""}, "name is empty"},
      {{"solve", input_, "--log="}, "--log"},
      {{"eval"}, "INPUT"},
      {{"info"}, "INPUT"},
      {{"eval", input_, "--method", "tnm"}, "--method"},
  };
  for (const Mistake& mistake : mistakes) {
    const Result result = run(mistake.arguments);
    EXPECT_EQ(result.code, 2) << mistake.complaint << ": " << result.errors;
    EXPECT_TRUE(contains(result.errors, mistake.complaint)) << result.errors;
    EXPECT_EQ(result.output, "") << mistake.complaint;
    EXPECT_FALSE(solved(result));
  }
}

TEST_F(WithScene, UsageIsCheckedBeforeTheInputIsRead) {
  EXPECT_EQ(run({"solve", "no such file", "--forcing", "2"}).code, 2);
  EXPECT_EQ(run({"solve", "no such file", "-o", "no/such/folder/out.txt"}).code, 1);
  EXPECT_EQ(run({"solve", "no such file"}).code, 3);
}

TEST_F(WithScene, BadInputEndsWithCode3AndItsPlace) {
  const std::string bad = (folder_ / "bad.txt").string();
  write_text(bad, "1 1 1\n0 0 1 x\n0 0 0 0 0 0 1 0 0 0 0 1\n");
  for (const char* command : {"solve", "eval", "info"}) {
    const Result result = run({command, bad});
    EXPECT_EQ(result.code, 3);
    EXPECT_TRUE(contains(result.errors, bad + ":2: found 'x', expected")) << result.errors;
    EXPECT_EQ(result.output, "");
  }
  EXPECT_EQ(run({"solve", "-"}, "/dev/null").code, 3);
}

TEST_F(WithScene, OutputsThatCannotBeWrittenAreRefusedBeforeTheSolve) {
  const std::string folder = folder_.path().string();
  write_text(folder_ / "file", "");
  for (const std::string& place : {folder + "/none/out.txt", folder, folder + "/file/out.txt",
                                   folder + "/", std::string("/proc/none")}) {
    for (const char* option : {"-o", "--log"}) {
      const Result result = run({"solve", input_, option, place});
      const bool is_folder = place == folder || place == folder + "/";
      EXPECT_EQ(result.code, is_folder && option == std::string("-o") ? 2 : 1) << place;
      EXPECT_FALSE(solved(result)) << place;
      EXPECT_TRUE(contains(result.errors, place)) << result.errors;
    }
  }
  EXPECT_EQ(folder_.entry_count(), 2);  // no probes left
}

TEST_F(WithScene, ADiskThatFillsUpEndsWithCode1) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  const std::string log = (folder_ / "log.json").string();
  const Result result = run({"solve", input_, "-q", "-o", "/dev/full", "--log", log});
  EXPECT_EQ(result.code, 1);
  EXPECT_TRUE(contains(result.errors, "/dev/full: cannot be written")) << result.errors;
  EXPECT_TRUE(nlohmann::json::parse(read_text(log)).contains("summary"));  // all the same
  EXPECT_NE(result.output, "");
}

TEST_F(WithScene, AReaderThatGoesAwayIsNoFailureOfAReport) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  ::close(ends[0]);
  const std::string out = (folder_ / "out.txt").string();
  EXPECT_EQ(Process({"eval", input_}, "/dev/null", ends[1]).wait(), 0);
  EXPECT_EQ(Process({"solve", input_, "-o", out}, "/dev/null", ends[1]).wait(), 0);
  EXPECT_TRUE(std::filesystem::exists(out));
  // Of a solution it is one.
  EXPECT_EQ(Process({"solve", input_, "-o", "-"}, "/dev/null", ends[1]).wait(), 1);
  ::close(ends[1]);
}

TEST_F(WithScene, QuietMeansNoProgress) {
  const Result loud = run({"solve", input_});
  EXPECT_TRUE(solved(loud));
  EXPECT_TRUE(contains(loud.errors, "reading " + input_ + "\n10 cameras, 400 points, "));
  const Result quiet = run({"solve", input_, "-q"});
  EXPECT_EQ(quiet.errors, "");
  EXPECT_TRUE(contains(quiet.output, "converged"));
}

TEST_F(WithScene, WarningsAreShown) {
  Problem problem = scene_;
  problem.points.insert(problem.points.end(), {1, 2, 3});
  io::write_bal(problem, input_);
  const std::string warning = "1 point is not observed";
  EXPECT_TRUE(contains(run({"solve", input_, "-q"}).errors, "warning: " + warning));
  EXPECT_TRUE(contains(run({"info", input_}).output, warning));
}

TEST_F(WithScene, InfoSaysTheSameInTextAndJson) {
  const Result text = run({"info", input_});
  EXPECT_EQ(text.code, 0);
  EXPECT_TRUE(contains(text.output, "advice\n  The default, --method auto"));
  const auto json = nlohmann::json::parse(run({"info", input_, "--json"}).output);
  EXPECT_EQ(json["cameras"], 10);
  EXPECT_EQ(json["points"], 400);
  EXPECT_EQ(json["observations"], scene_.observation_count());
  EXPECT_EQ(json["components"], 1);
  EXPECT_EQ(json["memory"].size(), 13U);
  for (const auto& each : json["memory"]) EXPECT_GT(each["bytes"], 1e6) << each;
  EXPECT_FALSE(json["advice"].empty());
  // A street: some points lie straight ahead, and angles are advised for them.
  const std::string collinear = std::to_string(json["collinear_points"].get<int>());
  EXPECT_TRUE(contains(text.output, collinear + " points along their observers' motion"));
  EXPECT_EQ(json["collinear_share"], json["collinear_points"].get<double>() / 400);
  EXPECT_TRUE(contains(text.output, "--points pmba, with lenses you trust"));
}

TEST(Cli, VersionSaysWhatItComputesWith) {
  const Result result = run({"version"});
  EXPECT_EQ(result.code, 0);
  for (const char* part : {version, "build", "kernels", "BLAS", "CHOLMOD", "Eigen"}) {
    EXPECT_TRUE(contains(result.output, part)) << part;
  }
}

TEST(Cli, AnInstructionSetThatIsNoneIsRefused) {
  const char* const before = std::getenv("RAYBUNDLE_ISA");
  const std::string kept = before == nullptr ? "" : before;
  const auto with = [](const char* value) {
    ::setenv("RAYBUNDLE_ISA", value, 1);  // the child inherits it
    return run({"version"});
  };
  const Result refused = with("foo");
  const Result lowered = with("baseline");
  const Result unset = with("");
  if (before == nullptr) {
    ::unsetenv("RAYBUNDLE_ISA");
  } else {
    ::setenv("RAYBUNDLE_ISA", kept.c_str(), 1);
  }
  EXPECT_EQ(refused.code, 2);
  EXPECT_TRUE(contains(refused.errors, "'foo' is none of baseline, avx2, avx512"));
  EXPECT_EQ(lowered.code, 0);
  EXPECT_TRUE(contains(lowered.output, "kernels  baseline")) << lowered.output;
  EXPECT_EQ(unset.code, 0);
}

struct Known {
  const char* file;
  const char* cost;
  int behind;
};

class KnownCost : public testing::TestWithParam<Known> {};

TEST_P(KnownCost, IsEvaluated) {
  const std::string file = std::string(RAYBUNDLE_DATA_DIR) + "/bal/" + GetParam().file;
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  const Result result = run({"eval", file});
  EXPECT_EQ(result.code, 0);
  EXPECT_TRUE(contains(result.output, GetParam().cost)) << result.output;
  EXPECT_TRUE(contains(result.output, " " + std::to_string(GetParam().behind) + " of "));
}

INSTANTIATE_TEST_SUITE_P(RealData, KnownCost,
                         testing::Values(Known{"problem-49-7776-pre.txt", "8.509125e+05", 31},
                                         Known{"problem-21-11315-pre.txt", "4.413239e+06", 0},
                                         Known{"problem-16-22106-pre.txt", "4.185660e+06", 0}),
                         [](const testing::TestParamInfo<Known>& parameter) {
                           return std::string(parameter.param.file).substr(8, 2);
                         });

}  // namespace
}  // namespace raybundle::tools
