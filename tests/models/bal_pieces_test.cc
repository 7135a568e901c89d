// Texts long enough to be read in pieces: as if they were read in order.

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/error.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/tests/support/bal_check.h>

namespace raybundle {
namespace {

using test::same_bits;

class BalPieces : public testing::Test {
 protected:
  // 1.4 MB: the parameters alone are cut into several pieces.
  BalPieces() : problem_(scenes::street({.cameras = 40, .points = 12000})) {
    std::string_view text = text_;
    while (!text.empty()) {
      const std::size_t length = text.find('\n') + 1;
      lines_.emplace_back(text.substr(0, length));
      text.remove_prefix(length);
    }
  }

  std::int64_t observations() const { return problem_.observation_count(); }
  std::string join() const {
    std::string text;
    for (const std::string& line : lines_) text += line;
    return text;
  }

  // The error is the same for any number of threads.
  static InputError error_of(const std::string& text) {
    std::vector<InputError> errors;
    for (const int threads : {1, 3}) {
      try {
        io::parse_bal(text, "text", threads);
        throw std::logic_error("nothing was refused");
      } catch (const InputError& error) {
        errors.push_back(error);
      }
    }
    EXPECT_STREQ(errors[0].what(), errors[1].what());
    return errors[0];
  }

  void expect_error(const std::string& text, std::int64_t line, const std::string& expected) {
    const InputError error = error_of(text);
    EXPECT_EQ(error.line(), line) << error.what();
    EXPECT_NE(error.expected().find(expected), std::string::npos) << error.what();
  }

  Problem problem_;
  std::string text_ = test::bal_text(problem_);
  std::vector<std::string> lines_;
};

TEST_F(BalPieces, ReadTheSameBits) {
  ASSERT_GT(text_.size(), std::size_t{1} << 20);
  for (const int threads : {1, 2, 5}) {
    EXPECT_TRUE(same_bits(io::parse_bal(text_, "text", threads), problem_)) << threads;
  }
}

TEST_F(BalPieces, WhiteSpaceMayDivideThemAnyhow) {
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    const bool parameter = i > static_cast<std::size_t>(observations());
    if (parameter && i % 9 != 0) lines_[i].back() = ' ';
    if (i % 1000 == 7) lines_[i] += " \r\n\n";
  }
  EXPECT_TRUE(same_bits(io::parse_bal(join(), "text", 3), problem_));
}

TEST_F(BalPieces, NameTheLineOfAnError) {
  for (const std::int64_t at : {std::int64_t{1}, observations() / 2, observations()}) {
    const std::string before = lines_[static_cast<std::size_t>(at)];
    lines_[static_cast<std::size_t>(at)] = "0 0 1.5 nan\n";
    expect_error(join(), at + 1, "y of observation " + std::to_string(at) + " of ");
    lines_[static_cast<std::size_t>(at)] = before;
  }
  const auto cameras = static_cast<std::int64_t>(problem_.cameras.size());
  lines_[static_cast<std::size_t>(observations() + cameras + 3 * 11999 + 2)] = "x\n";
  expect_error(join(), observations() + cameras + 3 * 11999 + 3, "y of point 11999");
  lines_[static_cast<std::size_t>(observations() + 9 * 39 + 7)] = "1e999\n";
  expect_error(join(), observations() + 9 * 39 + 8, "focal length of camera 39");
}

TEST_F(BalPieces, TheFirstOfSeveralErrorsIsNamed) {
  for (std::size_t i = 5000; i < lines_.size(); i += 5000) lines_[i] = "no number\n";
  expect_error(join(), 5001, "camera index of observation 5000");
}

TEST_F(BalPieces, WhatIsMissingIsMissingAtTheEnd) {
  const auto cut = [&](std::int64_t lines) {
    std::string text;
    for (std::int64_t i = 0; i < lines; ++i) text += lines_[static_cast<std::size_t>(i)];
    return text;
  };
  // So little text that the header cannot be true, then as much as it takes at least.
  expect_error(cut(observations() / 20), 1, "no more than fits");
  const std::string padding(text_.size(), ' ');
  expect_error(cut(1 + observations() / 2) + padding, 1 + observations() / 2,
               "camera index of observation " + std::to_string(observations() / 2 + 1));
  expect_error(cut(1 + observations()) + padding, 1 + observations(),
               "rotation vector x of camera 0");
  expect_error(cut(static_cast<std::int64_t>(lines_.size()) - 1),
               static_cast<std::int64_t>(lines_.size()) - 1, "z of point 11999");
}

TEST_F(BalPieces, WhatIsTooMuchIsNamed) {
  const auto lines = static_cast<std::int64_t>(lines_.size());
  expect_error(text_ + "\n\n7\n", lines + 3, "the end of the file");
  expect_error(text_ + std::string(text_.size(), '\n') + "7",
               lines + 1 + static_cast<std::int64_t>(text_.size()), "the end of the file");
}

}  // namespace
}  // namespace raybundle
