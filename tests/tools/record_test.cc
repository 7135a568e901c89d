// What a record has to say of a start and of the file of a solution.

#include <raybundle/tools/record.h>

#include <gtest/gtest.h>

#include <raybundle/solver/options.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle::tools {
namespace {

SolveRecord behind(std::int64_t observations) {
  SolveRecord record;
  record.before.behind_camera = record.after.behind_camera = observations;
  return record;
}

TEST(StartWarnings, CoordinatesBehindTheirCamerasMakeNoGoodRays) {
  const Options rays = resolve({.objective = ObjectiveKind::ray});
  EXPECT_TRUE(start_warnings(behind(0), rays).empty());
  EXPECT_EQ(start_warnings(behind(2), rays).size(), 1U);
  EXPECT_TRUE(start_warnings(behind(2), resolve({})).empty()) << "pixels do not tell";
  const Options anchored = resolve({.points = PointModel::pmba, .objective = ObjectiveKind::ray});
  EXPECT_TRUE(start_warnings(behind(2), anchored).empty());
}

TEST(StartWarnings, EigenvaluesOfAFreeGaugeAreRounding) {
  EXPECT_EQ(start_warnings({}, resolve({.diagnose = true})).size(), 1U);
  EXPECT_TRUE(start_warnings({}, resolve({.gauge = Gauge::fixed, .diagnose = true})).empty());
}

TEST(FileWarnings, TellWhatAFormatDoesNotHold) {
  Problem problem = test::small_problem();
  SolveRecord record = behind(2);
  EXPECT_TRUE(file_warnings(record, problem, false).empty());
  EXPECT_EQ(file_warnings(record, problem, true).size(), 1U);
  problem.aspect = 1.01;
  EXPECT_EQ(file_warnings(record, problem, false).size(), 1U);
  record.summary.options.objective = ObjectiveKind::ray;
  EXPECT_EQ(file_warnings(record, problem, false).size(), 1U) << "coordinates are what they are";
  record.summary.options.points = PointModel::pmba;
  EXPECT_EQ(file_warnings(record, problem, false).size(), 2U);
}

}  // namespace
}  // namespace raybundle::tools
