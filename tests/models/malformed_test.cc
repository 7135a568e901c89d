// Every kind of malformed BAL text is refused with the line it is on and words that help.

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <ostream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/error.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/tests/support/bal_check.h>
#include <raybundle/tests/support/mutate.h>
#include <raybundle/tests/support/random_problem.h>

namespace raybundle {
namespace {

/// A valid file: line 1 the header, 2-5 observations, 6-23 cameras, 24-32 points.
std::vector<std::string> valid_lines() {
  std::vector<std::string> lines = {"2 3 4", "0 0 1.5 -2.5", "1 0 3 4", "0 1 -5 6", "1 2 7e0 -8"};
  for (int i = 0; i < 18; ++i) lines.push_back(std::to_string(i) + ".25");
  for (int i = 0; i < 9; ++i) lines.push_back("-" + std::to_string(i) + "e-1");
  return lines;
}

std::string join(const std::vector<std::string>& lines, const std::string& line_end = "\n") {
  std::string text;
  for (const std::string& line : lines) text += line + line_end;
  return text;
}

std::string valid() { return join(valid_lines()); }

/// The valid file with one line (counted from 1) replaced.
std::string with_line(std::size_t number, const std::string& line) {
  std::vector<std::string> lines = valid_lines();
  lines[number - 1] = line;
  return join(lines);
}

std::string without_line(std::size_t number) {
  std::vector<std::string> lines = valid_lines();
  lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(number - 1));
  return join(lines);
}

std::string with_line_before(std::size_t number, const std::string& line) {
  std::vector<std::string> lines = valid_lines();
  lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(number - 1), line);
  return join(lines);
}

std::string first_lines(std::size_t count) {
  std::vector<std::string> lines = valid_lines();
  lines.resize(count);
  return join(lines);
}

struct Malformed {
  std::string name;
  std::string text;
  std::int64_t line;
  std::string piece;  // of the message
};

std::ostream& operator<<(std::ostream& out, const Malformed& malformed) {
  return out << malformed.name;
}

std::vector<Malformed> malformed_headers() {
  const std::string nul(1, '\0');
  return {
      {"empty file", "", 1, "found nothing (an empty file), expected the number of cameras"},
      {"only white space", " \n\t\r\n", 1, "found nothing (an empty file)"},
      {"one number", "2", 1, "found the end of the file, expected the number of points"},
      {"two numbers", with_line(1, "2 3"), 1,
       "found the end of the line, expected the number of "
       "observations"},
      {"four numbers", with_line(1, "2 3 4 5"), 1, "found '5', expected the end of the line"},
      {"header over two lines", with_line(1, "2 3\n4"), 1, "the number of observations"},
      {"words", "hello world\n", 1, "found 'hello', expected the number of cameras, 1 to"},
      {"comment", with_line_before(1, "# Bundle file v0.3"), 1, "found '#'"},
      {"html", "<!DOCTYPE html>\n<html>", 1, "found '<!DOCTYPE'"},
      {"byte order mark", "\xEF\xBB\xBF" + valid(), 1, "a UTF-8 byte order mark"},
      {"UTF-16", std::string("\xFF\xFE") + "2" + nul + " " + nul, 1, R"('\xFF\xFE2\x00')"},
      {"binary", "\x7F-ELF\x02\x01" + nul + nul, 1, R"('\x7F-ELF\x02\x01\x00\x00')"},
      {"compressed data", std::string("\x1F\x8B\x08") + nul, 1, R"('\x1F\x8B)"},
      {"long garbage is cut short", std::string(100000, 'x'), 1, std::string(40, 'x') + "...'"},
      {"no cameras", with_line(1, "0 3 4"), 1, "found '0', expected the number of cameras"},
      {"no points", with_line(1, "2 0 4"), 1, "found '0', expected the number of points"},
      {"no observations", with_line(1, "2 3 0"), 1, "found '0', expected the number of obs"},
      {"negative cameras", with_line(1, "-2 3 4"), 1, "found '-2'"},
      {"negative points", with_line(1, "2 -3 4"), 1, "found '-3'"},
      {"negative observations", with_line(1, "2 3 -4"), 1, "found '-4'"},
      {"cameras beyond 32 bits", with_line(1, "2147483648 3 4"), 1, "1 to 2147483647"},
      {"points beyond 32 bits", with_line(1, "2 4294967299 4"), 1, "1 to 2147483647"},
      {"observations beyond 64 bits", with_line(1, "2 3 9223372036854775808"), 1,
       "1 to 9223372036854775807"},
      {"a count that is no integer", with_line(1, "2 3.0 4"), 1, "found '3.0'"},
      {"a count with an exponent", with_line(1, "2 3 4e0"), 1, "found '4e0'"},
      {"a hexadecimal count", with_line(1, "0x2 3 4"), 1, "found '0x2'"},
      {"commas in the header", with_line(1, "2,3,4"), 1, "found '2,3,4'"},
      {"promises too many cameras", with_line(1, "2147483647 3 4"), 1,
       "found a header that promises 2147483647 cameras, 3 points and 4 observations, expected no "
       "more than fits into the"},
      {"promises too many points", with_line(1, "2 2147483647 4"), 1, "no more than fits into"},
      {"promises too many observations", with_line(1, "2 3 9223372036854775807"), 1,
       "no more than fits into"},
      {"promises a little too much", "1 1 1\n0 0 1 2\n" + std::string(22, '1'), 1,
       "no more than fits into the 31 bytes after it"},
      {"header only", "2 3 4\n", 1, "no more than fits into the 1 bytes after it"},
  };
}

std::vector<Malformed> malformed_observations() {
  return {
      {"camera index too large", with_line(3, "2 0 3 4"), 3,
       "found '2', expected the camera index of observation 2 of 4, 0 to 1"},
      {"camera index negative", with_line(3, "-1 0 3 4"), 3, "found '-1', expected the camera"},
      {"point index too large", with_line(4, "0 3 -5 6"), 4,
       "found '3', expected the point index of observation 3 of 4, 0 to 2"},
      {"point index negative", with_line(4, "0 -1 -5 6"), 4, "found '-1', expected the point"},
      {"index beyond 32 bits", with_line(4, "0 4294967296 -5 6"), 4, "found '4294967296'"},
      {"index beyond 64 bits", with_line(4, "99999999999999999999 0 -5 6"), 4, "camera index"},
      {"index that is no integer", with_line(2, "0 1.0 1 2"), 2, "found '1.0'"},
      {"index that is a word", with_line(2, "0 a 1 2"), 2, "found 'a'"},
      {"x missing", with_line(3, "1 0"), 3,
       "found the end of the line, expected a finite number, x"},
      {"y missing does not eat the next line", with_line(3, "1 0 3"), 3,
       "found the end of the line, expected a finite number, y of observation 2 of 4"},
      {"y missing before CR LF", with_line(3, "1 0 3\r"), 3, "found the end of the line"},
      {"observation over two lines", with_line(3, "1 0\n3 4"), 3, "found the end of the line"},
      {"two observations on a line", with_line(2, "0 0 1 2 1 0 3 4"), 2,
       "found '1', expected the end of the line after y of observation 1 of 4"},
      {"depth in a fifth column", with_line(5, "1 2 7 -8 0.5"), 5, "found '0.5'"},
      {"x is nan", with_line(2, "0 0 nan 1"), 2, "found 'nan', expected a finite number, x of obs"},
      {"y is inf", with_line(2, "0 0 1 inf"), 2, "found 'inf', expected a finite number, y of obs"},
      {"x is -inf", with_line(2, "0 0 -inf 1"), 2, "found '-inf'"},
      {"x overflows", with_line(2, "0 0 1e999 1"), 2, "found '1e999'"},
      {"x is a hex float", with_line(2, "0 0 0x1p3 1"), 2, "found '0x1p3'"},
      {"decimal comma", with_line(2, "0 0 1,5 1"), 2, "found '1,5'"},
      {"commas between", with_line(2, "0, 0, 1, 1"), 2, "found '0,'"},
      {"x is a word", with_line(2, "0 0 x 1"), 2, "found 'x'"},
      {"two signs", with_line(2, "0 0 +-1 1"), 2, "found '+-1'"},
      {"sign alone", with_line(2, "0 0 - 1"), 2, "found '-'"},
      {"plus alone", with_line(2, "0 0 1 +"), 2, "found '+'"},
      {"point alone", with_line(2, "0 0 . 1"), 2, "found '.'"},
      {"exponent without digits", with_line(2, "0 0 1e 1"), 2, "found '1e'"},
      {"Fortran exponent", with_line(2, "0 0 1.5D+00 1"), 2, "found '1.5D+00'"},
      {"digits grouped", with_line(2, "0 0 1_000 1"), 2, "found '1_000'"},
      {"no-break space",
       with_line(2,
                 "0 0 1\xC2\xA0"
                 "1"),
       2, "found '1\\xC2\\xA01'"},
      {"NUL in a number", with_line(2, "0 0 1" + std::string(1, '\0') + "5 1"), 2, "'1\\x005'"},
      {"NUL for a blank", with_line(2, "0 0" + std::string(1, '\0') + "1 1"), 2, "'0\\x001'"},
      {"one observation too few", without_line(5), 5, "found '0.25', expected the camera index"},
      {"line ends of old computers", join(valid_lines(), "\r"), 1, "the end of the line after the"},
  };
}

std::vector<Malformed> malformed_parameters() {
  const std::string whole = valid();
  return {
      {"cut after the observations", first_lines(5) + std::string(60, ' '), 5,
       "found the end of the file, expected a finite number, rotation vector x of camera 0"},
      {"cut within the cameras", first_lines(12) + std::string(60, '\n'), 12,
       "found the end of the file, expected a finite number, distortion k1 of camera 0 (of 0 to "
       "1)"},
      {"cut within the points", first_lines(31), 31,
       "found the end of the file, expected a finite number, z of point 2 (of 0 to 2)"},
      {"cut within a number", whole.substr(0, whole.size() - 2), 32, "found '-8e-'"},
      {"one observation too many", with_line_before(6, "1 1 2 2"), 30,
       "expected the end of the fi"},
      {"text after the last number", whole + "end\n", 33,
       "found 'end', expected the end of the file after what the header promises: 2 cameras, 3 "
       "points and 4 observations"},
      {"one number too many", whole + "\n\n0\n", 35, "found '0', expected the end of the file"},
      {"NUL bytes after the last number", whole + std::string(512, '\0'), 33, "'\\x00\\x00"},
      {"end-of-file character of DOS", whole + "\x1A", 33, "found '\\x1A'"},
      {"two files in one", whole + whole, 33, "found '2', expected the end of the file"},
      {"a camera with nan", with_line(12, "nan"), 12,
       "found 'nan', expected a finite number, focal length of camera 0 (of 0 to 1)"},
      {"a camera with -nan(ind)", with_line(6, "-nan(ind)"), 6, "found '-nan(ind)'"},
      {"a camera with 1.#IND", with_line(6, "1.#IND"), 6, "found '1.#IND'"},
      {"a camera that overflows", with_line(22, "-1e309"), 22, "distortion k1 of camera 1"},
      {"overflow without an exponent", with_line(22, "1" + std::string(309, '0')), 22, "k1 of cam"},
      {"overflow of the exponent", with_line(22, "1e99999999999999999999"), 22, "k1 of camera 1"},
      {"a point with infinity", with_line(25, "infinity"), 25,
       "found 'infinity', expected a finite "
       "number, y of point 0"},
      {"a point with a word", with_line(32, "z"), 32, "z of point 2"},
      {"a point with a comma", with_line(24, "1,"), 24, "x of point 0"},
      {"a comment between", with_line_before(24, "# points"), 24, "found '#'"},
  };
}

std::vector<Malformed> all_malformed() {
  std::vector<Malformed> all = malformed_headers();
  for (const auto& table : {malformed_observations(), malformed_parameters()}) {
    all.insert(all.end(), table.begin(), table.end());
  }
  return all;
}

class MalformedBal : public testing::TestWithParam<Malformed> {};

TEST_P(MalformedBal, IsRefusedWithLineAndWords) {
  const Malformed& malformed = GetParam();
  try {
    io::parse_bal(malformed.text, "scene.txt");
    FAIL() << "was read";
  } catch (const InputError& error) {
    EXPECT_EQ(error.source(), "scene.txt");
    EXPECT_EQ(error.line(), malformed.line) << error.what();
    EXPECT_NE(std::string(error.what()).find(malformed.piece), std::string::npos) << error.what();
    EXPECT_LT(std::string_view(error.what()).size(), 300U);
  }
}

/// The name as GoogleTest wants it: letters, digits and underscores.
std::string test_name(const testing::TestParamInfo<Malformed>& parameter) {
  std::string name = parameter.param.name;
  const auto is_odd = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; };
  std::replace_if(name.begin(), name.end(), is_odd, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Table, MalformedBal, testing::ValuesIn(all_malformed()), test_name);

TEST(MalformedBalText, TheTableIsLongAndItsBaseIsValid) {
  EXPECT_GE(all_malformed().size(), 45U);
  EXPECT_EQ(io::parse_bal(valid(), "valid").observation_count(), 4);
}

TEST(MalformedBalText, EveryPrefixIsRefused) {
  // Up to the sign of the last number; one of its digits is enough.
  const std::string text = valid();
  const std::size_t longest = text.rfind("\n-") + 2;
  for (std::size_t size = 0; size <= longest; ++size) {
    EXPECT_THROW(io::parse_bal(std::string_view(text).substr(0, size), "cut"), InputError) << size;
  }
  EXPECT_NO_THROW(io::parse_bal(std::string_view(text).substr(0, longest + 1), "whole"));
}

TEST(MalformedBalText, MutationsAreReadOrRefused) {
  const std::string text = test::bal_text(test::random_problem(7, 3, 8, 20));
  int read = 0;
  constexpr int rounds = 2000;
  for (int i = 0; i < rounds; ++i) {
    const std::string damaged = test::Mutator(static_cast<std::uint64_t>(i))(text);
    ASSERT_NO_THROW(if (test::read_or_refuse(damaged))++ read) << "seed " << i;
  }
  // Both kinds must come up, or the mutations would test little.
  EXPECT_GT(read, rounds / 20);
  EXPECT_LT(read, rounds / 2);
}

}  // namespace
}  // namespace raybundle
