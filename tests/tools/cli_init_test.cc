// raybundle init and rotations: what they write, and what they refuse.

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <raybundle/models/alignment.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tests/tools/process.h>

namespace raybundle::tools {
namespace {

using nlohmann::json;
using test::contains;
using test::read_text;
using test::Result;
using test::run;
using test::TemporaryFolder;
using test::Words;
using test::write_text;

class Init : public testing::Test {
 protected:
  Init() {
    Problem problem = add_noise(scene_, {.pixel_noise = 0.5}).problem;
    for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
      if (i % 9 < 6) problem.cameras[i] = 0;
    }
    io::write_bal(problem, input_);
  }
  std::string path(const char* name) const { return (folder_ / name).string(); }
  void expect_refused(const Words& words, int code, const std::string& complaint) const {
    const Result result = run(words);
    EXPECT_EQ(result.code, code) << complaint << ": " << result.errors;
    EXPECT_TRUE(contains(result.errors, complaint)) << complaint << ": " << result.errors;
  }

  TemporaryFolder folder_;
  scenes::Scene scene_ = scenes::street_scene({.cameras = 12, .points = 500});
  std::string input_ = path("input.txt");
};

TEST_F(Init, WritesAStartAndSaysWhatItDid) {
  const Result result =
      run({"init", input_, "-o", path("start.txt"), "--log", path("log.json"), "--seed", "4"});
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_TRUE(contains(result.output, "12 cameras (100.0 %)")) << result.output;
  EXPECT_TRUE(contains(result.errors, "pairs")) << result.errors;
  const json log = json::parse(read_text(path("log.json")));
  EXPECT_EQ(log["schema"], 1);
  EXPECT_EQ(log["pipeline"], "global");
  EXPECT_EQ(log["placed"]["cameras"], 12);
  EXPECT_EQ(log["images"], std::vector<std::string>(12, "placed"));
  EXPECT_GT(log["pairs"]["edges"], 11);
  EXPECT_LT(log["rotations"]["after"]["median"], 1);
  const Problem start = io::read_bal(path("start.txt"));
  const TruthErrors errors = compare_with_truth(start, scene_.truth);
  EXPECT_LT(errors.camera_rmse, 0.3) << "steps";
  EXPECT_LT(errors.rotation_mean, 0.5) << "degrees";
}

TEST_F(Init, GoesImageByImageWhenAsked) {
  const Result result = run({"init", input_, "--pipeline", "incremental", "--log", path("log.json"),
                             "-o", path("start.txt"), "-q"});
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  const json log = json::parse(read_text(path("log.json")));
  EXPECT_EQ(log["pipeline"], "incremental");
  EXPECT_GE(log["bundle_adjustments"], 3);
  EXPECT_EQ(log["placed"]["cameras"], io::read_bal(path("start.txt")).camera_count());
}

TEST_F(Init, SendsTheReportElsewhereWhenStandardOutputIsTaken) {
  const Result result = run({"init", input_, "-q", "-o", "-"});
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_TRUE(contains(result.errors, "placed"));
  EXPECT_FALSE(contains(result.output, "placed"));
  EXPECT_EQ(io::parse_bal(result.output, "output").camera_count(), 12);
}

TEST_F(Init, RefusesWhatMakesNoSense) {
  expect_refused({"init", input_, "--pipeline", "both"}, 2, "none of global, incremental");
  expect_refused({"init", input_, "--threshold", "0"}, 2, "--threshold: 0 is less than");
  expect_refused({"init", input_, "--min-common", "5"}, 2, "--min-common: 5 is less than 6");
  expect_refused({"init", input_, "--threads", "-1"}, 2, "--threads");
  expect_refused({"init", input_, "-o", input_}, 2, "--output");
  expect_refused({"init", input_, "-o", path("a"), "--log", path("a")}, 2, "are the same");
  expect_refused({"init", input_, "-o", folder_.path().string()}, 2, "folder");
  expect_refused({"init", input_, "--min-common", "400"}, 3, "no two images with a relative pose");
  expect_refused({"init", path("none.txt")}, 3, "none.txt");
}

constexpr const char* quarter = "0 -1 0 1 0 0 0 0 1";  // about z

TEST_F(Init, AveragesRotations) {
  write_text(path("EGs.txt"), std::string("3 5 ") + quarter + " 0 0 1\n5 9 " + quarter +
                                  " 0 0 1\n9 3 0 0 0 0 0 0 0 0 0 0 0 0\n");
  expect_refused({"rotations", path("EGs.txt")}, 3, "EGs.txt:3");
  write_text(path("EGs.txt"),
             std::string("3 5 ") + quarter + " 0 0 1\n5 9 " + quarter + " 0 0 1\n");
  const Result result = run({"rotations", path("EGs.txt"), "-o", path("R.txt")});
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_TRUE(contains(result.output, "2 pairs of 3 images")) << result.output;
  const std::string text = read_text(path("R.txt"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
  EXPECT_TRUE(text.starts_with("3 ")) << text;
  expect_refused({"rotations", path("EGs.txt"), "--prune", "0"}, 2, "--prune");
  write_text(path("EGs.txt"), std::string("3 3 ") + quarter + " 0 0 1\n");
  expect_refused({"rotations", path("EGs.txt")}, 3, "two images");
}

}  // namespace
}  // namespace raybundle::tools
