// raybundle solve with a robust loss: changes of its scale, robust figures, and warnings about ends
// that only look well.

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <raybundle/models/io/bal.h>
#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/presets.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tests/tools/process.h>
#include <raybundle/tools/progress.h>
#include <raybundle/tools/record.h>

namespace raybundle::tools {
namespace {

using nlohmann::json;
using test::contains;
using test::read_text;
using test::Result;
using test::run;
using test::TemporaryFolder;
using test::Words;

TEST(ProgressTable, SaysWhereTheScaleOfTheLossChanges) {
  ProgressTable table;
  IterationRecord record;
  record.accepted = true;
  record.cost = 1000;
  record.loss_scale = 37.25;
  EXPECT_EQ(table.next(record), ProgressTable::header() + ProgressTable::row(record));
  record.iteration = 1;
  EXPECT_EQ(table.next(record), ProgressTable::row(record));
  record.iteration = 2;
  record.loss_scale = 18.625;
  record.cost = 400;
  record.rho = 0.5;
  record.predicted_decrease = 200;
  EXPECT_EQ(table.next(record),
            "      loss scale 37.25 -> 18.62 px: the cost so far becomes 5.000000e+02\n" +
                ProgressTable::row(record));
  record.iteration = 3;
  EXPECT_EQ(table.next(record), ProgressTable::row(record));
  record.iteration = 4;
  record.loss_scale = 10;
  record.accepted = false;  // the state is still that of the row before
  record.cost = 300;
  EXPECT_TRUE(contains(table.next(record), "10 px: the cost so far becomes 3.000000e+02\n"));
}

TEST(ResultWarnings, AreOfLossesThatLevelOff) {
  SolveRecord record;
  record.observations = 10;
  record.before.rmse = 7;
  record.after.rmse = 13;
  record.robust_after = RobustStatistics{.median = 1, .within = 5};
  const auto with = [&record](Loss loss) {
    record.summary.options.loss = loss;
    return result_warnings(record);
  };
  EXPECT_TRUE(with(Loss::truncated).empty());
  record.robust_after->within = 4;
  ASSERT_EQ(with(Loss::truncated).size(), 1U);
  EXPECT_TRUE(contains(with(Loss::truncated)[0], "more than half")) << with(Loss::truncated)[0];
  record.robust_after->within = 5;
  record.after.rmse = 6e11;
  for (const Loss loss : {Loss::geman_mcclure, Loss::tukey, Loss::truncated}) {
    ASSERT_EQ(with(loss).size(), 1U);
    EXPECT_TRUE(contains(with(loss)[0], "more than twice that of the start")) << with(loss)[0];
  }
  for (const Loss loss : {Loss::none, Loss::huber, Loss::soft_l1, Loss::cauchy}) {
    EXPECT_TRUE(with(loss).empty());
  }
}

/// A scene with outliers from a start much worse than any loss by itself allows for.
class SolveWithLoss : public testing::Test {
 protected:
  SolveWithLoss() {
    const scenes::Preset preset = scenes::preset("sphere-10");
    scene_ = scenes::perturb(
        scenes::add_noise(scenes::preset_scene(preset, 1), {.seed = 1, .outlier_share = 0.1})
            .problem,
        preset.start);
    io::write_bal(scene_, input_);
  }
  Result solved(Words words) const {
    words.insert(words.begin(), {"solve", input_, "-o", output_, "--log", log_});
    return run(words);
  }

  TemporaryFolder folder_;
  Problem scene_;
  std::string input_ = (folder_ / "scene.txt").string();
  std::string output_ = (folder_ / "out.txt").string();
  std::string log_ = (folder_ / "log.json").string();
};

TEST_F(SolveWithLoss, WarnsWhereTheStartWasTakenForOutliers) {
  const Result result = solved({"--loss", "truncated", "-q"});
  EXPECT_EQ(result.code, 0);
  EXPECT_TRUE(contains(result.errors, "warning: more than half of the observations are beyond"))
      << result.errors;
  EXPECT_TRUE(contains(result.errors, "--loss-start-scale (irls does by itself)"));
  const json summary = json::parse(read_text(log_))["summary"];
  EXPECT_EQ(summary["warnings"].size(), 1U);
  EXPECT_LT(summary["final_within_loss_scale"], 0.5);
}

TEST_F(SolveWithLoss, ShowsRobustFiguresAndTheScalesOfAGraduatedSolve) {
  const Result result = solved({"--method", "irls"});
  EXPECT_EQ(result.code, 0);
  EXPECT_TRUE(contains(result.errors, "      loss scale ")) << result.errors;
  EXPECT_FALSE(contains(result.errors, "warning")) << result.errors;
  EXPECT_TRUE(contains(result.output, "both at the final scale of the loss")) << result.output;
  EXPECT_TRUE(contains(result.output, "median residual")) << result.output;
  EXPECT_TRUE(contains(result.output, "within the scale")) << result.output;
  const json summary = json::parse(read_text(log_))["summary"];
  const double count = static_cast<double>(scene_.observation_count());
  const RobustStatistics before = robust_statistics(scene_, 6);
  const RobustStatistics after = robust_statistics(io::read_bal(output_), 6);
  EXPECT_EQ(summary["initial_median_residual"].get<double>(), before.median);
  EXPECT_EQ(summary["final_median_residual"].get<double>(), after.median);
  EXPECT_EQ(summary["initial_within_loss_scale"], static_cast<double>(before.within) / count);
  EXPECT_EQ(summary["final_within_loss_scale"], static_cast<double>(after.within) / count);
  EXPECT_NEAR(summary["final_within_loss_scale"], 0.9, 0.02);
  EXPECT_TRUE(summary["warnings"].empty());
}

TEST_F(SolveWithLoss, PlainSquaresHaveNoScale) {
  const Result result = solved({});
  EXPECT_EQ(result.code, 0);
  EXPECT_FALSE(contains(result.output, "within the scale"));
  EXPECT_FALSE(contains(result.errors, "loss scale"));
  const json summary = json::parse(read_text(log_))["summary"];
  EXPECT_TRUE(summary["final_median_residual"].is_null());
  EXPECT_TRUE(summary["final_within_loss_scale"].is_null());
}

}  // namespace
}  // namespace raybundle::tools
