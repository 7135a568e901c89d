// raybundle eval: the loss, the truth, and the files it writes.

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/alignment.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tests/tools/process.h>
#include <raybundle/version.h>

namespace raybundle::tools {
namespace {

using nlohmann::json;
using test::contains;
using test::read_text;
using test::Result;
using test::run;
using test::TemporaryFolder;
using test::Words;

class EvalCommand : public testing::Test {
 protected:
  EvalCommand() {
    for (double& x : truth_.points) x += 0.01;
    truth_.points[4] += 0.3;
    truth_.cameras[3] += 0.2;
    io::write_bal(scene_, input_);
    io::write_bal(truth_, truth_file_);
  }
  std::string path(const char* name) const { return (folder_ / name).string(); }

  json evaluated(Words options) const {
    options.insert(options.begin(), {"eval", input_, "--log", path("log.json")});
    const Result result = run(options);
    EXPECT_EQ(result.code, 0) << result.errors;
    return json::parse(read_text(path("log.json")));
  }

  TemporaryFolder folder_;
  Problem scene_ = scenes::street({.seed = 3, .cameras = 10, .points = 400});
  Problem truth_ = scene_;
  std::string input_ = path("scene.txt");
  std::string truth_file_ = path("truth.txt");
};

TEST_F(EvalCommand, LogHasExactNumbers) {
  const json log = evaluated({});
  const ReprojectionStatistics expected = reprojection_statistics(scene_);
  EXPECT_EQ(log["schema"], 1);
  EXPECT_EQ(log["version"], version);
  EXPECT_EQ(log["problem"]["source"], input_);
  EXPECT_EQ(log["problem"]["cameras"], 10);
  EXPECT_EQ(log["problem"]["points"], 400);
  EXPECT_EQ(log["problem"]["observations"], scene_.observation_count());
  EXPECT_EQ(log["pixel_cost"].get<double>(), expected.cost);
  EXPECT_EQ(log["rmse"].get<double>(), expected.rmse);
  EXPECT_EQ(log["largest"].get<double>(), expected.largest);
  EXPECT_EQ(log["behind_cameras"], expected.behind_camera);
  EXPECT_NEAR(log["cost"].get<double>(), expected.cost, 1e-12 * expected.cost);
  EXPECT_TRUE(log["loss"].is_null());
  EXPECT_TRUE(log["truth"].is_null());
}

TEST_F(EvalCommand, CostFollowsTheLoss) {
  const char* const names[] = {"none",          "huber", "soft-l1",  "cauchy",
                               "geman-mcclure", "tukey", "truncated"};
  linalg::ThreadPool pool(2);
  for (int kind = 1; kind < 7; ++kind) {
    for (const LossScope scope : {LossScope::observation, LossScope::component}) {
      const char* scope_name = scope == LossScope::observation ? "observation" : "component";
      const json log =
          evaluated({"--loss", names[kind], "--loss-scale", "2.5", "--loss-scope", scope_name});
      Objective objective(scene_, {}, pool, {static_cast<Loss>(kind), scope, 2.5});
      EXPECT_EQ(log["cost"].get<double>(), objective.cost(objective.state_of(scene_)));
      EXPECT_EQ(log["pixel_cost"].get<double>(), reprojection_statistics(scene_).cost);
      EXPECT_EQ(log["loss"], (json{{"kind", names[kind]}, {"scope", scope_name}, {"scale", 2.5}}));
    }
  }
  EXPECT_EQ(evaluated({"--loss", "huber"})["loss"]["scale"], 1);
}

TEST_F(EvalCommand, ComparesWithTheTruth) {
  const json log = evaluated({"--truth", truth_file_});
  const TruthErrors expected = compare_with_truth(scene_, truth_);
  EXPECT_GT(expected.camera_rmse, 0);
  EXPECT_EQ(log["truth"]["source"], truth_file_);
  EXPECT_EQ(log["truth"]["cameras"], expected.cameras);
  EXPECT_EQ(log["truth"]["points"], expected.points);
  EXPECT_EQ(log["truth"]["camera_rmse"].get<double>(), expected.camera_rmse);
  EXPECT_EQ(log["truth"]["point_rmse"].get<double>(), expected.point_rmse);
  EXPECT_EQ(log["truth"]["point_median"].get<double>(), expected.point_median);
  EXPECT_EQ(log["truth"]["rotation_mean_degrees"].get<double>(), expected.rotation_mean);
  const Result result = run({"eval", input_, "--truth", truth_file_});
  EXPECT_TRUE(contains(result.output, "RMSE of camera centres")) << result.output;
  EXPECT_TRUE(contains(result.output, "10 of 10 cameras")) << result.output;
  EXPECT_FALSE(contains(result.output, "warning")) << result.output;
}

TEST_F(EvalCommand, SaysWhenAFarPointDecidesTheAlignment) {
  scene_.points[3] += 1e6;
  io::write_bal(scene_, input_);
  const json log = evaluated({"--truth", truth_file_});
  const TruthErrors expected = compare_with_truth(scene_, truth_);
  EXPECT_EQ(log["truth"]["camera_scale"].get<double>(), expected.camera_alignment.scale);
  EXPECT_EQ(log["truth"]["point_scale"].get<double>(), expected.point_alignment.scale);
  EXPECT_EQ(log["truth"]["point_rmse_by_cameras"].get<double>(), expected.point_rmse_by_cameras);
  EXPECT_EQ(log["truth"]["point_median_own"].get<double>(), expected.point_median_own);
  EXPECT_LT(expected.point_alignment.scale, 0.5 * expected.camera_alignment.scale);
  const Result result = run({"eval", input_, "--truth", truth_file_});
  EXPECT_TRUE(contains(result.output, "a few far points dominate")) << result.output;
}

std::vector<std::vector<double>> read_csv(const std::string& file, const std::string& header) {
  std::istringstream lines(read_text(file));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, header);
  std::vector<std::vector<double>> rows;
  while (std::getline(lines, line)) {
    rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) {
      rows.back().push_back(std::stod(field));
    }
  }
  return rows;
}

TEST_F(EvalCommand, TablesPerCameraAndPoint) {
  const std::string header = ",observations,rmse,largest,x,y,z";
  evaluated({"--cameras-csv", path("c.csv"), "--points-csv", path("p.csv")});
  EXPECT_EQ(read_csv(path("c.csv"), "camera" + header).size(), 10U);
  EXPECT_EQ(read_csv(path("p.csv"), "point" + header).size(), 400U);

  evaluated(
      {"--cameras-csv", path("c.csv"), "--points-csv", path("p.csv"), "--truth", truth_file_});
  const ReprojectionBreakdown parts = reprojection_breakdown(scene_);
  const TruthErrors errors = compare_with_truth(scene_, truth_);
  const std::vector<double> centres = camera_centres(scene_);
  const auto cameras = read_csv(path("c.csv"), "camera" + header + ",error");
  for (std::size_t j = 0; j < 10; ++j) {
    EXPECT_EQ(cameras[j],
              (std::vector<double>{
                  static_cast<double>(j), static_cast<double>(parts.cameras[j].observations),
                  parts.cameras[j].rmse, parts.cameras[j].largest, centres[3 * j],
                  centres[3 * j + 1], centres[3 * j + 2], errors.camera_errors[j]}));
  }
  const auto points = read_csv(path("p.csv"), "point" + header + ",error");
  ASSERT_EQ(points.size(), 400U);
  EXPECT_EQ(points[1][4], scene_.points[3]);
  EXPECT_EQ(points[1][7], errors.point_errors[1]);
}

TEST_F(EvalCommand, ReportGivesWayOnStandardOutput) {
  const Result result = run({"eval", input_, "--log", "-"});
  EXPECT_EQ(result.code, 0);
  EXPECT_TRUE(json::accept(result.output)) << result.output;
  EXPECT_TRUE(contains(result.errors, "largest residual"));
}

TEST_F(EvalCommand, MistakesAreRefused) {
  struct Mistake {
    Words arguments;
    std::string complaint;
  };
  const std::vector<Mistake> mistakes = {
      {{"--loss-scale", "2"}, "--loss-scale has no effect"},
      {{"--loss-scope", "component"}, "--loss-scope has no effect"},
      {{"--loss", "none", "--loss-scale", "2"}, "--loss-scale has no effect"},
      {{"--loss", "l2"}, "'l2' is none of none, huber"},
      {{"--loss", "huber", "--loss-scale", "0"}, "'0' is not a number"},
      {{"--loss", "huber", "--loss-scale", "nan"}, "'nan' is not a number"},
      {{"--log", "x.json", "--cameras-csv", "x.json"}, "are the same"},
      {{"--cameras-csv", "-", "--points-csv", "-"}, "are the same"},
      {{"--log", input_}, "is the input"},
      {{"--truth", truth_file_, "--log", truth_file_}, "is the input"},
      {{"--truth", ""}, "name is empty"}};
  for (const Mistake& mistake : mistakes) {
    Words words = {"eval", input_};
    words.insert(words.end(), mistake.arguments.begin(), mistake.arguments.end());
    const Result result = run(words);
    EXPECT_EQ(result.code, 2) << mistake.complaint << ": " << result.errors;
    EXPECT_TRUE(contains(result.errors, mistake.complaint)) << result.errors;
  }
  EXPECT_EQ(run({"eval", "-", "--truth", "-"}).code, 2);
  EXPECT_EQ(run({"eval", input_, "--log", "no/such/folder/x.json"}).code, 1);
}

TEST_F(EvalCommand, TruthOfAnotherProblemIsBadInput) {
  io::write_bal(scenes::street({.seed = 3, .cameras = 9, .points = 400}), truth_file_);
  const Result result = run({"eval", input_, "--truth", truth_file_});
  EXPECT_EQ(result.code, 3);
  EXPECT_TRUE(contains(result.errors, "found 9 cameras, expected 10")) << result.errors;
}

}  // namespace
}  // namespace raybundle::tools
