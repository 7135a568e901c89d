// What is legal in a BAL file, and that writing loses nothing.

#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <locale>
#include <random>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include <raybundle/models/error.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/io/file_content.h>
#include <raybundle/tests/support/bal_check.h>
#include <raybundle/tests/support/random_problem.h>
#include <raybundle/tests/support/temporary_folder.h>

namespace raybundle {
namespace {

using test::random_problem;
using test::same_bits;

const std::string parameters = "0 0 0 0 0 -5 800 0 0\n1 2 3\n";

TEST(Bal, ReadsAllParts) {
  const Problem problem = io::parse_bal(
      "2 2 3\n0 0 1.5 -2.5\n1 0 3 4\n1 1 5 6\n"
      "1\n2\n3\n4\n5\n6\n7\n8\n9\n10\n11\n12\n13\n14\n15\n16\n17\n18\n-1\n-2\n-3\n-4\n-5\n-6\n",
      "text");
  EXPECT_EQ(problem.camera_count(), 2);
  EXPECT_EQ(problem.point_count(), 2);
  EXPECT_EQ(problem.observation_camera, (std::vector<std::int32_t>{0, 1, 1}));
  EXPECT_EQ(problem.observation_point, (std::vector<std::int32_t>{0, 0, 1}));
  EXPECT_EQ(problem.observations, (std::vector<double>{1.5, -2.5, 3, 4, 5, 6}));
  EXPECT_EQ(problem.cameras[17], 18);
  EXPECT_EQ(problem.points, (std::vector<double>{-1, -2, -3, -4, -5, -6}));
  EXPECT_TRUE(problem.fixed_camera_parameters.empty());
  EXPECT_TRUE(problem.fixed_points.empty());
}

TEST(Bal, WhiteSpaceOfAnyKindIsTheSame) {
  const Problem plain = io::parse_bal("1 1 1\n0 0 1 2\n" + parameters, "text");
  for (const std::string text : {
           "1 1 1\r\n0 0 1 2\r\n0 0 0\r\n0 0 -5 800 0 0 1 2 3\r\n",         // CR LF
           "\n\n 1\t1\t1 \n\n\t0\t0\t1\t2\t\n0 0 0 0 0\t-5 800 0 0 1 2 3",  // blank lines, no end
           "1 1 1\n0 0 1 2\n0\n0\n0\n0\n0\n-5\n800\n0\n0\n1\n2\n3\n\n \n",
           "1 1 1\n0 0 1 2\n0 0 0 0 0 -5 800\n0 0 1\n\v\f2 3",
       }) {
    EXPECT_TRUE(same_bits(io::parse_bal(text, "text"), plain)) << text;
  }
}

TEST(Bal, NumbersOfAnySpellingAreTheSame) {
  const Problem plain = io::parse_bal("1 1 1\n0 0 1 2\n" + parameters, "text");
  const Problem other = io::parse_bal(
      "+1 01 1\n-0 +0 +1.0 .2E+1\n0 0. .0 0e5 00 -0.5e1 8e+2 0 0 1. 2.0000000000000000000000000 "
      "300e-2",
      "text");
  EXPECT_TRUE(same_bits(other, plain));
}

TEST(Bal, ExtremeNumbersKeepTheirBits) {
  const Problem problem = io::parse_bal(
      "1 1 1\n0 0 -0 -0.0e9\n"
      "4.9e-324 -2.2250738585072011e-308 1.7976931348623157e308 1e-400 -1e-400 "
      "-0.000001e-99999999999999999999 2e-324 0e99999 3e-324 "
      "9007199254740993 0.1 123456789012345678901234567890\n",
      "text");
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
  EXPECT_EQ(bits(problem.observations[0]), bits(-0.0));
  EXPECT_EQ(bits(problem.observations[1]), bits(-0.0));
  EXPECT_EQ(problem.cameras[0], std::numeric_limits<double>::denorm_min());
  EXPECT_EQ(problem.cameras[1], -0x0.fffffffffffffp-1022);
  EXPECT_EQ(problem.cameras[2], std::numeric_limits<double>::max());
  EXPECT_EQ(bits(problem.cameras[3]), bits(0.0));  // too small: a zero of the same sign
  EXPECT_EQ(bits(problem.cameras[4]), bits(-0.0));
  EXPECT_EQ(bits(problem.cameras[5]), bits(-0.0));
  EXPECT_EQ(bits(problem.cameras[6]), bits(0.0));
  EXPECT_EQ(bits(problem.cameras[7]), bits(0.0));
  EXPECT_EQ(problem.cameras[8], std::numeric_limits<double>::denorm_min());  // rounds up
  EXPECT_EQ(problem.points[0], 9007199254740992.0);                          // a tie: to even
  EXPECT_EQ(problem.points[1], 0.1);
  EXPECT_EQ(problem.points[2], 123456789012345678901234567890.0);
}

TEST(Bal, UnobservedAndTwiceObservedAreLegal) {
  const Problem problem = io::parse_bal(
      "2 2 2\n1 0 1 2\n1 0 1 2\n0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1 2 3 4 5 6\n", "text");
  EXPECT_EQ(problem.observation_count(), 2);
  EXPECT_NO_THROW(validate(problem));
}

TEST(Bal, SmallestFileThatKeepsItsPromise) {
  // Exactly as many bytes as the header check asks for.
  EXPECT_NO_THROW(io::parse_bal("1 1 1\n0 0 1 2\n0 0 0 0 0 0 0 0 0 1 2 3", "text"));
}

TEST(Bal, WritingReadsBackBitIdentical) {
  // Doubles of all magnitudes: random bits.
  Problem problem = random_problem(3, 20, 3000, 500);
  std::mt19937_64 random(4);
  for (double& value : problem.points) {
    do {
      value = std::bit_cast<double>(random());
    } while (!std::isfinite(value));
  }
  const std::string text = test::bal_text(problem);
  const Problem read = io::parse_bal(text, "text");
  EXPECT_TRUE(same_bits(read, problem));
  EXPECT_EQ(test::bal_text(read), text);
}

TEST(Bal, WritesOneObservationAndOneParameterPerLine) {
  const Problem problem =
      io::parse_bal("1 1 2\n0 0 0.1 -2.50\n0 0 1e+300 3\n" + parameters, "text");
  EXPECT_EQ(test::bal_text(problem),
            "1 1 2\n0 0 0.1 -2.5\n0 0 1e+300 3\n0\n0\n0\n0\n0\n-5\n800\n0\n0\n1\n2\n3\n");
}

struct CommaPoint : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(Bal, NoLocaleChangesAnything) {
  const Problem problem = io::parse_bal("1 1 1\n0 0 1234567.5 2\n" + parameters, "text");
  const std::string expected = test::bal_text(problem);
  const std::locale comma(std::locale::classic(), new CommaPoint);
  const std::locale before = std::locale::global(comma);
  std::ostringstream out;
  out.imbue(comma);
  io::write_bal(problem, out);
  const Problem read = io::parse_bal(out.str(), "text");
  std::locale::global(before);
  EXPECT_EQ(out.str(), expected);
  EXPECT_TRUE(same_bits(read, problem));
}

TEST(Bal, RefusesToWriteWhatItWouldNotRead) {
  const test::TemporaryFolder folder;
  Problem problem = random_problem(1, 2, 3, 4);
  problem.points[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(io::write_bal(problem, folder / "out.txt"), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "out.txt"));
}

TEST(Bal, AFailedStreamThrows) {
  std::ostringstream out;
  out.setstate(std::ios::badbit);
  EXPECT_THROW(io::write_bal(random_problem(1, 2, 3, 4), out), std::system_error);
}

TEST(Bal, ErrorsOfFilesNameThem) {
  const test::TemporaryFolder folder;
  const auto message = [&](const std::filesystem::path& path) -> std::string {
    try {
      io::read_bal(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const std::string missing = (folder / "missing.txt").string();
  EXPECT_EQ(
      message(missing),
      missing +
          ": found nothing readable (No such file or directory), expected a file that can be read");
  EXPECT_EQ(message(folder.path())
                .find(folder.path().string() + ": found nothing readable (Is a directory)"),
            0U);
  test::write_text(folder / "empty.txt", "");
  EXPECT_EQ(message(folder / "empty.txt").find((folder / "empty.txt").string() + ":1: "), 0U);
}

class RealBal : public testing::TestWithParam<const char*> {};

TEST_P(RealBal, WritingReadsBackBitIdentical) {
  const auto source = std::filesystem::path(RAYBUNDLE_DATA_DIR) / "bal" / GetParam();
  if (!std::filesystem::exists(source)) GTEST_SKIP() << "no " << source;
  const test::TemporaryFolder folder;
  const Problem problem = io::read_bal(source);
  EXPECT_NO_THROW(validate(problem));
  io::write_bal(problem, folder / "out.txt");
  EXPECT_TRUE(same_bits(io::read_bal(folder / "out.txt"), problem));
}

INSTANTIATE_TEST_SUITE_P(Files, RealBal,
                         testing::Values("problem-49-7776-pre.txt", "problem-21-11315-pre.txt",
                                         "problem-16-22106-pre.txt"),
                         [](const auto& parameter) {
                           return "file" + std::to_string(parameter.index);
                         });

TEST(Validate, RefusesWhatDoesNotFitTogether) {
  const Problem good = random_problem(1, 2, 3, 4);
  EXPECT_NO_THROW(validate(good));
  const auto expect_refused = [&](const std::string& piece, auto&& change) {
    Problem problem = good;
    change(problem);
    try {
      validate(problem);
      ADD_FAILURE() << "valid, not: " << piece;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(piece), std::string::npos) << error.what();
    }
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  expect_refused("17 camera parameters", [](Problem& p) { p.cameras.pop_back(); });
  expect_refused("8 point coordinates", [](Problem& p) { p.points.pop_back(); });
  expect_refused("0 cameras", [](Problem& p) { p.cameras.clear(); });
  expect_refused("0 points", [](Problem& p) { p.points.clear(); });
  expect_refused("0 observations", [](Problem& p) { p.observation_camera.clear(); });
  expect_refused("3 point indices", [](Problem& p) { p.observation_point.pop_back(); });
  expect_refused("7 image coordinates", [](Problem& p) { p.observations.pop_back(); });
  expect_refused("camera 2 in observation 1", [](Problem& p) { p.observation_camera[1] = 2; });
  expect_refused("point -1 in observation 3", [](Problem& p) { p.observation_point[3] = -1; });
  expect_refused("nan in camera 1", [](Problem& p) { p.cameras[9] = nan; });
  expect_refused("nan in point 2", [](Problem& p) { p.points[8] = nan; });
  expect_refused("inf in observation 0", [](Problem& p) { p.observations[1] = HUGE_VAL; });
  expect_refused("1 masks", [](Problem& p) { p.fixed_camera_parameters = {0}; });
  expect_refused("a mask of 512", [](Problem& p) { p.fixed_camera_parameters = {0, 512}; });
  expect_refused("4 marks", [](Problem& p) { p.fixed_points = {0, 0, 0, 1}; });
}

}  // namespace
}  // namespace raybundle
