// What a solve is predicted to take is what it takes, and a limit holds.

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tests/tools/process.h>
#include <raybundle/tools/bench_process.h>

namespace raybundle {
namespace {

using nlohmann::json;
using test::run;

struct Scene {
  const char* name;
  std::vector<std::string> words;
};

class PredictedMemory : public testing::TestWithParam<Scene> {
 protected:
  void SetUp() override {
    if (!tools::limits_memory()) GTEST_SKIP() << "a sanitizer takes memory of its own";
    std::vector<std::string> words = {"generate"};
    words.insert(words.end(), GetParam().words.begin(), GetParam().words.end());
    words.insert(words.end(), {"-o", input_});
    ASSERT_EQ(run(words).code, 0);
    estimates_ = json::parse(run({"info", input_, "--json"}).output)["memory"];
  }

  double predicted(const std::string& method, const std::string& linear,
                   const char* key = "bytes") const {
    for (const json& each : estimates_) {
      const bool points = each["elimination"] == "points";
      if (each["method"] == method && points && (linear.empty() || each["linear"] == linear)) {
        return each[key];
      }
    }
    ADD_FAILURE() << "no estimate for " << method;
    return 0;
  }

  double measured(const std::vector<std::string>& options) {
    std::vector<std::string> words = {"solve", input_, "-q", "--log", log_, "--max-iterations",
                                      "2"};
    words.insert(words.end(), options.begin(), options.end());
    EXPECT_EQ(run(words).code, 0);
    return json::parse(test::read_text(log_))["summary"]["peak_rss_bytes"];
  }

  test::TemporaryFolder folder_;
  std::string input_ = folder_.path() / "scene.txt";
  std::string log_ = folder_.path() / "log.json";
  json estimates_;
};

TEST_P(PredictedMemory, IsWhatASolveTakes) {
  for (const char* method : {"auto", "tnm", "dinm"}) {
    const double bytes = measured({"--method", method});
    EXPECT_NEAR(predicted(method, ""), bytes, 0.1 * bytes) << method;
  }
  const double dense = measured({"--method", "lm-cholesky", "--linear", "dense-cholesky"});
  EXPECT_NEAR(predicted("lm-cholesky", "dense-cholesky"), dense, 0.1 * dense);
  const double two_levels = measured({"--method", "tnm", "--preconditioner", "two-level"});
  EXPECT_NEAR(predicted("tnm", "", "bytes_of_two_levels"), two_levels, 0.1 * two_levels);
}

TEST_P(PredictedMemory, OfMoreThanTheLimitIsRefusedWithTheFigures) {
  const double needed = predicted("tnm", "");
  const auto limited = [&](double share) {
    return run({"solve", input_, "-q", "--method", "tnm", "--max-iterations", "1", "--memory-limit",
                std::to_string(static_cast<std::int64_t>(share * needed))});
  };
  EXPECT_EQ(limited(1.2).code, 0);
  const auto refused = limited(0.8);
  EXPECT_EQ(refused.code, 5);
  EXPECT_NE(refused.errors.find("not enough memory: solving "), std::string::npos)
      << refused.errors;
  EXPECT_NE(refused.errors.find("the limit is "), std::string::npos) << refused.errors;
}

TEST_P(PredictedMemory, AMatrixThatIsTooMuchIsRefusedOrNotChosen) {
  const double needed = predicted("tnm", "");
  const double matrix = predicted("lm-cholesky", "dense-cholesky") - needed;
  const std::string limit = std::to_string(static_cast<std::int64_t>(1.1 * needed));
  ASSERT_GT(matrix, 0.3 * needed);
  const auto forced = run({"solve", input_, "-q", "--method", "lm-cholesky", "--linear",
                           "dense-cholesky", "--max-iterations", "1", "--memory-limit", limit});
  EXPECT_EQ(forced.code, 5) << forced.errors;
  EXPECT_NE(forced.errors.find("factorising a matrix of order "), std::string::npos)
      << forced.errors;
  const auto chosen =
      run({"solve", input_, "-q", "--max-iterations", "1", "--memory-limit", limit});
  EXPECT_EQ(chosen.code, 0) << chosen.errors;
  EXPECT_NE(chosen.output.find("conjugate gradients"), std::string::npos) << chosen.output;
}

// 1,128,750 pairs of cameras: 0.7 GB of numbers.
TEST(Info, TellsOfAMatrixThatIsTooMuchAndWhatToDo) {
  if (!tools::limits_memory()) GTEST_SKIP() << "a sanitizer takes memory of its own";
  const test::TemporaryFolder folder;
  const std::string input = folder.path() / "scene.txt";
  const std::vector<std::string> sphere = {"sphere", "--cameras", "1500", "--points", "40"};
  std::vector<std::string> words = {"generate", "-o", input};
  words.insert(words.begin() + 1, sphere.begin(), sphere.end());
  ASSERT_EQ(run(words).code, 0);
  const auto result = tools::run_process(
      {.command = {RAYBUNDLE_CLI, "info", input}, .bytes = std::uint64_t{500} << 20U});
  EXPECT_EQ(result.code, 0) << result.output;
  const char* estimate = "lm-cholesky  xyz   eliminating points   sparse-cholesky  at least 1.";
  EXPECT_NE(result.output.find(estimate), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("too much for the"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("--method tnm iterates"), std::string::npos) << result.output;
}

TEST(MemoryLimit, IsASizeWithAUnit) {
  const auto with = [](const char* limit) {
    return run({"solve", "-q", "--max-iterations", "1", "--memory-limit", limit});
  };
  for (const char* size : {"1.5GB", "2GiB", "900MB", "1500000000"}) {
    EXPECT_EQ(with(size).code, 0) << size;
  }
  for (const char* size : {"1.5XB", "GB", "1..5GB", "1.5e9", "-1GB", ""}) {
    EXPECT_EQ(with(size).code, 2) << size;
  }
  EXPECT_NE(with("4XB").errors.find("'4XB' is not a size such as 4GB"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, PredictedMemory,
    testing::Values(Scene{"photos", {"photos", "--cameras", "200", "--points", "30000"}},
                    Scene{"street", {"street", "--cameras", "400", "--points", "12000"}}),
    [](const auto& scene) { return scene.param.name; });

}  // namespace
}  // namespace raybundle
