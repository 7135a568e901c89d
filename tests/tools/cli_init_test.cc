// raybundle init and rotations: what they write, and what they refuse.

#include <algorithm>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
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
  EXPECT_LT(log["rotations"]["angles"]["after"]["median"], 1);
  const Problem start = io::read_bal(path("start.txt"));
  const TruthErrors errors = compare_with_truth(start, scene_.truth);
  EXPECT_LT(errors.camera_rmse, 0.3) << "steps";
  EXPECT_LT(errors.rotation_mean, 0.5) << "degrees";
}

TEST_F(Init, KeepsGivenRotationsAndFindsPositions) {
  Problem given = io::read_bal(input_);
  for (std::size_t i = 0; i < given.cameras.size(); ++i) {
    if (i % 9 < 3) given.cameras[i] = scene_.truth.cameras[i];
  }
  io::write_bal(given, path("given.txt"));
  const Result result = run({"init", path("given.txt"), "--rotations", "problem", "--loss", "none",
                             "-q", "-o", path("start.txt"), "--log", path("log.json")});
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_EQ(json::parse(read_text(path("log.json")))["rotations"]["from"], "problem");
  const Problem start = io::read_bal(path("start.txt"));
  ASSERT_EQ(start.camera_count(), 12);
  for (std::size_t i = 0; i < start.cameras.size(); ++i) {
    if (i % 9 < 3) {
      EXPECT_NEAR(start.cameras[i], given.cameras[i], 1e-12) << i;
    }
  }
  EXPECT_LT(compare_with_truth(start, scene_.truth).camera_rmse, 0.1) << "steps";
}

TEST_F(Init, SaysWhatWasFoundWhereNothingCanBePlaced) {
  Problem given = io::read_bal(input_);
  for (std::size_t i = 0; i < given.cameras.size(); i += 9) {
    given.cameras[i] = 0.05 * static_cast<double>(i);
  }
  io::write_bal(given, path("turned.txt"));
  expect_refused({"init", path("turned.txt"), "--rotations", "problem", "-o", path("start.txt"),
                  "--log", path("log.json")},
                 3, "within 6 degrees");
  const json log = json::parse(read_text(path("log.json")));
  EXPECT_EQ(log["ending"], "disagreement");
  EXPECT_EQ(log["placed"]["cameras"], 0);
  EXPECT_EQ(log["edges"].size(), log["pairs"]["edges"]);
  EXPECT_TRUE(log["positions"]["final_cost"].is_null());
  EXPECT_FALSE(std::filesystem::exists(path("start.txt")));
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
  expect_refused({"init", input_, "--threshold", "0"}, 2, "--threshold: '0' is not a number from");
  expect_refused({"init", input_, "--min-common", "5"}, 2,
                 "--min-common: '5' is not a whole number from 6");
  expect_refused({"init", input_, "--threads", "-1"}, 2, "--threads");
  expect_refused({"init", input_, "--rotations", "mine"}, 2, "none of pairs, problem");
  expect_refused({"init", input_, "--pipeline", "incremental", "--rotations", "problem"}, 2,
                 "--rotations has no effect");
  expect_refused({"init", input_, "--loss", "none", "--loss-scale", "2"}, 2,
                 "--loss-scale has no effect");
  expect_refused({"init", input_, "-o", input_}, 2, "--output");
  expect_refused({"init", input_, "-o", path("a"), "--log", path("a")}, 2, "are the same");
  expect_refused({"init", input_, "-o", folder_.path().string()}, 2, "folder");
  expect_refused({"init", input_, "--min-common", "400"}, 3, "no two images have 400 points");
  expect_refused({"init", path("none.txt")}, 3, "none.txt");
}

constexpr const char* quarter = "0 -1 0 1 0 0 0 0 1";  // about z
constexpr const char* other = "1 0 0 0 0 -1 0 1 0";    // about x

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Lines "image R".
std::map<int, RowMajor> read_rotations(const std::string& file) {
  std::istringstream lines(read_text(file));
  std::map<int, RowMajor> result;
  for (int image = 0; lines >> image;) {
    for (double& entry : result[image].reshaped<Eigen::RowMajor>()) lines >> entry;
  }
  return result;
}

// A line "i j R t" says that R_i = R R_j: of turns about different axes no other order will do.
TEST_F(Init, ReadsRelativeRotationsAsTheFormatHasThem) {
  write_text(path("EGs.txt"), std::string("3 5 ") + quarter + " 0 0 1\n5 9 " + other + " 0 0 1\n");
  const Result result = run({"rotations", path("EGs.txt"), "-o", path("R.txt")});
  ASSERT_EQ(result.code, 0) << result.errors;
  const auto R = read_rotations(path("R.txt"));
  ASSERT_EQ(R.size(), 3U);
  RowMajor R_35, R_59;
  R_35 << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  R_59 << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  EXPECT_LT((R.at(3) * R.at(5).transpose() - R_35).norm(), 1e-9);
  EXPECT_LT((R.at(5) * R.at(9).transpose() - R_59).norm(), 1e-9);
}

TEST_F(Init, AveragesRotations) {
  write_text(path("EGs.txt"), std::string("3 5 ") + quarter + " 0 0 1\n5 9 " + quarter +
                                  " 0 0 1\n9 3 0 0 0 0 0 0 0 0 0 0 0 0\n");
  expect_refused({"rotations", path("EGs.txt")}, 3, "EGs.txt:3");
  write_text(path("EGs.txt"),
             std::string("3 5 ") + quarter + " 0 0 1\n5 9 " + quarter + " 0 0 1\n");
  const Result result =
      run({"rotations", path("EGs.txt"), "-o", path("R.txt"), "--log", path("R.json")});
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_TRUE(contains(result.output, "2 pairs of 3 images")) << result.output;
  EXPECT_EQ(read_rotations(path("R.txt")).size(), 3U);
  const json log = json::parse(read_text(path("R.json")));
  EXPECT_EQ(log["known"], 3);
  EXPECT_EQ(log["pruned"], 0);
  EXPECT_LT(log["angles"]["after"]["largest"], 1e-6);
  expect_refused({"rotations", path("EGs.txt"), "-o", path("a"), "--log", path("a")}, 2,
                 "are the same");
  expect_refused({"rotations", path("EGs.txt"), "--prune", "0"}, 2, "--prune");
  write_text(path("EGs.txt"), std::string("3 3 ") + quarter + " 0 0 1\n");
  expect_refused({"rotations", path("EGs.txt")}, 3, "two images");
}

}  // namespace
}  // namespace raybundle::tools
