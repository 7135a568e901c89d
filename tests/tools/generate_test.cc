// raybundle generate, as its users meet it.

#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/io/bal.h>
#include <raybundle/models/scenes/presets.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tests/tools/process.h>

namespace raybundle::tools {
namespace {

using test::contains;
using test::Result;
using test::run;
using test::TemporaryFolder;
using test::Words;

class Generate : public testing::Test {
 protected:
  Result generate(Words words) const {
    words.insert(words.begin(), "generate");
    words.insert(words.end(), {"-o", output_});
    return run(words);
  }

  TemporaryFolder folder_;
  std::string output_ = (folder_ / "scene.txt").string();
  std::string truth_ = (folder_ / "scene.truth.txt").string();
};

TEST_F(Generate, WritesStartAndTruthOfEveryKind) {
  for (const std::string kind : {"sphere", "street", "aerial", "photos"}) {
    const Result result = generate({kind, "--cameras", "12", "--points", "300"});
    ASSERT_EQ(result.code, 0) << result.errors;
    const Problem start = io::read_bal(output_);
    const Problem truth = io::read_bal(truth_);
    EXPECT_EQ(start.camera_count(), 12);
    EXPECT_EQ(start.point_count(), 300);
    EXPECT_EQ(start.observations, truth.observations);
    EXPECT_EQ(start.observation_camera, truth.observation_camera);
    const double rmse = reprojection_statistics(truth).rmse;
    EXPECT_GT(rmse, 1.2) << kind;  // 1 pixel in either direction
    EXPECT_LT(rmse, 1.6) << kind;
    EXPECT_GT(reprojection_statistics(start).rmse, 3 * rmse) << kind;
    EXPECT_TRUE(contains(result.output, "scene.truth.txt")) << result.output;
    EXPECT_TRUE(contains(result.output, "300")) << result.output;
  }
}

TEST_F(Generate, IsTheLibrarysPreset) {
  const Result result = generate({"sphere-10", "--seed", "7"});
  ASSERT_EQ(result.code, 0) << result.errors;
  const scenes::Scene scene = scenes::preset_scene(scenes::preset("sphere-10"), 7);
  const Problem truth = io::read_bal(truth_);
  EXPECT_EQ(truth.cameras, scene.truth.cameras);
  EXPECT_EQ(truth.points, scene.truth.points);
  EXPECT_EQ(truth.observation_count(), 1834);
}

TEST_F(Generate, TheStreetThatSolveMakesHasTheSameTruth) {
  ASSERT_EQ(generate({"street", "--seed", "5"}).code, 0);
  const std::string made = (folder_ / "made.txt").string();
  ASSERT_EQ(run({"solve", "--seed", "5", "--max-iterations", "0", "-o", made}).code, 0);
  Problem problem = io::read_bal(made);
  const Problem truth = io::read_bal(truth_);
  EXPECT_EQ(problem.observation_camera, truth.observation_camera);
  EXPECT_EQ(problem.observation_point, truth.observation_point);
  problem.cameras = truth.cameras;
  problem.points = truth.points;
  EXPECT_NEAR(reprojection_statistics(problem).rmse, 0.5 * std::sqrt(2), 0.01);
}

TEST_F(Generate, ScalesPresets) {
  ASSERT_EQ(generate({"trafalgar-257", "--scale", "0.1"}).code, 0);
  const Problem start = io::read_bal(output_);
  EXPECT_EQ(start.camera_count(), 26);
  EXPECT_EQ(start.point_count(), 6513);
}

TEST_F(Generate, NoiseSeedLeavesTheSceneAsItIs) {
  ASSERT_EQ(generate({"sphere"}).code, 0);
  const Problem one = io::read_bal(truth_);
  ASSERT_EQ(generate({"sphere", "--noise-seed", "2"}).code, 0);
  const Problem two = io::read_bal(truth_);
  EXPECT_EQ(one.cameras, two.cameras);
  EXPECT_EQ(one.points, two.points);
  EXPECT_NE(one.observations, two.observations);
  ASSERT_EQ(generate({"sphere", "--seed", "2"}).code, 0);
  EXPECT_NE(one.cameras, io::read_bal(truth_).cameras);
}

TEST_F(Generate, TakesNoiseAndStart) {
  const Result exact =
      generate({"sphere", "--pixel-noise", "0", "--start-rotation", "0", "--start-position", "0",
                "--start-focal", "0", "--start-point", "0"});
  ASSERT_EQ(exact.code, 0) << exact.errors;
  EXPECT_LT(reprojection_statistics(io::read_bal(truth_)).rmse, 1e-9);
  EXPECT_EQ(io::read_bal(output_).points, io::read_bal(truth_).points);
  const Result outliers = generate({"sphere", "--pixel-noise", "0", "--outliers", "0.1"});
  ASSERT_EQ(outliers.code, 0) << outliers.errors;
  EXPECT_GT(reprojection_statistics(io::read_bal(truth_)).rmse, 30);
}

TEST_F(Generate, KeepsTrueLenses) {
  const auto lenses = [](const Problem& problem) {
    std::vector<double> all;
    for (std::size_t k = 0; k < problem.cameras.size(); ++k) {
      if (k % 9 >= 6) all.push_back(problem.cameras[k]);
    }
    return all;
  };
  ASSERT_EQ(generate({"street", "--true-lenses"}).code, 0);
  const Problem start = io::read_bal(output_);
  EXPECT_EQ(lenses(start), lenses(io::read_bal(truth_)));
  EXPECT_NE(start.cameras, io::read_bal(truth_).cameras);
  ASSERT_EQ(generate({"street"}).code, 0);
  EXPECT_NE(lenses(io::read_bal(output_)), lenses(io::read_bal(truth_)));
  const Result both = generate({"street", "--true-lenses", "--start-focal", "0.1"});
  EXPECT_EQ(both.code, 2);
  EXPECT_TRUE(contains(both.errors, "--start-focal has no effect")) << both.errors;
}

TEST_F(Generate, SaysWhichObservationsAreOutliers) {
  const std::string list = (folder_ / "scene.outliers.txt").string();
  ASSERT_EQ(generate({"sphere"}).code, 0);
  const Problem clean = io::read_bal(truth_);
  EXPECT_FALSE(std::filesystem::exists(list));  // there are none
  const Result result = generate({"sphere", "--outliers", "0.1"});
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_TRUE(contains(result.output, list)) << result.output;
  const Problem dirty = io::read_bal(truth_);
  std::string expected;
  for (std::size_t k = 0; k < clean.observation_camera.size(); ++k) {
    const bool moved = clean.observations[2 * k] != dirty.observations[2 * k];
    if (moved) expected += std::to_string(k) + "\n";
  }
  EXPECT_GT(expected.size(), 300U);
  EXPECT_EQ(test::read_text(list), expected);
}

TEST_F(Generate, WarnsOfObservationsItCannotGive) {
  const Words words = {"photos", "--cameras", "100", "--points", "200", "--observations", "19000"};
  const Result result = generate(words);
  EXPECT_EQ(result.code, 0);
  EXPECT_TRUE(contains(result.errors, "instead of 19000")) << result.errors;
  EXPECT_EQ(generate({"street", "--observations", "9000"}).errors, "");
}

TEST_F(Generate, StandardOutputTakesTheProblemAlone) {
  const Result result = run({"generate", "sphere", "-o", "-"});
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_EQ(io::parse_bal(result.output, "-").camera_count(), 10);
  EXPECT_TRUE(contains(result.errors, "observations"));
  const Result named = run({"generate", "sphere", "-o", "-", "--truth", truth_});
  ASSERT_EQ(named.code, 0) << named.errors;
  EXPECT_EQ(io::read_bal(truth_).camera_count(), 10);
}

TEST_F(Generate, RefusesWhatHasNoEffectOrNoSense) {
  const std::vector<std::pair<Words, std::string>> cases = {
      {{"cube"},
       "'cube' is neither a kind (sphere, street, aerial, photos) nor a preset (sphere-10,"},
      {{"sphere", "--lap", "200"}, "--lap has no effect"},
      {{"sphere", "--height", "20"}, "--height has no effect"},
      {{"street", "--region", "1"}, "--region has no effect"},
      {{"street", "--sights", "2"}, "--sights has no effect"},
      {{"photos", "--far", "0.1"}, "--far has no effect"},
      {{"aerial", "--scale", "2"}, "--scale has no effect"},
      {{"sphere-11"},
       "'sphere-11' is neither a kind (sphere, street, aerial, photos) nor a preset"},
      {{"sphere-10", "--cameras", "20"}, "--cameras has no effect"},
      {{"sphere-10", "--points", "20"}, "--points has no effect"},
      {{"sphere-10", "--observations", "20"}, "--observations has no effect"},
      {{"sphere-10", "--region", "1"}, "--region has no effect: sphere-10 is a preset"},
      {{"sphere", "--observations", "1834", "--region", "1"}, "--region has no effect"},
      {{"sphere", "--observations", "10"}, "10 observations"},
      {{"sphere", "--cameras", "1"}, "1 cameras"},
      {{"sphere", "--cameras", "x"}, "--cameras"},
      {{"sphere", "--seed", "-1"}, "--seed"},
      {{"sphere", "--outliers", "1.5"}, "outlier share"},
      {{"sphere", "--pixel-noise", "-1"}, "pixel noise"},
      {{"sphere", "--pixel-noise", "nan"}, "pixel noise"},
      {{"sphere", "--start-focal", "1"}, "focal noise"},
      {{"street", "--lap", "30"}, "lap of 30"},
      {{"ladybug-1723", "--scale", "-1"}, "scale of -1, expected 1e-06 to 10"},
      {{"sphere", "--truth", output_}, "are the same"},
      {{"sphere", "--truth", (folder_ / "." / "scene.txt").string()}, "are the same"},
      {{"sphere", "--truth", ""}, "the name is empty"},
      {{"sphere", "--outliers", "0.1", "--truth", (folder_ / "scene.outliers.txt").string()},
       "where the list of outliers goes"},
      {{"sphere", "--truth", truth_ + ".gz"}, "would not be compressed"},
  };
  for (const auto& [words, expected] : cases) {
    const Result result = generate(words);
    EXPECT_EQ(result.code, 2) << words.back() << result.errors;
    EXPECT_TRUE(contains(result.errors, expected)) << result.errors;
    EXPECT_FALSE(std::filesystem::exists(output_)) << words.back();
  }
}

TEST_F(Generate, AnUnwritableTruthIsFoundOutBefore) {
  const Result result = generate({"sphere", "--truth", (folder_ / "none" / "t.txt").string()});
  EXPECT_EQ(result.code, 1);
  EXPECT_FALSE(std::filesystem::exists(output_));
}

}  // namespace
}  // namespace raybundle::tools
