#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>

namespace raybundle::io {

constexpr bool is_space(char c) {
  return c == ' ' || static_cast<unsigned char>(c - '\t') <= '\r' - '\t';
}

/// Walks over a text of numbers and white space, strictly: a number must be followed by white space
/// or the end. Keeps a reference to the text. Only errors count lines, so that reading is fast.
///
/// Numbers are decimal, independent of the locale, with an optional sign. A literal too small for a
/// double reads as a zero of its sign; one too large is an error, as are nan, inf and hex floats.
class TextReader {
 public:
  /// `source` names the text in errors.
  TextReader(std::string_view text, std::string source);

  std::int64_t position() const { return at_ - begin_; }  ///< bytes read
  void move_to(std::int64_t position) { at_ = begin_ + position; }
  std::int64_t remaining() const { return end_ - at_; }  ///< bytes not read yet
  bool at_end() const { return at_ == end_; }
  bool at_line_end() const { return at_end() || *at_ == '\n'; }

  /// To the next token, or the end of the line. A carriage return is white space.
  void skip_blanks() {
    while (at_ != end_ && *at_ != '\n' && is_space(*at_)) ++at_;
  }
  /// To the next token, on whichever line, or the end of the text.
  void skip_space() {
    while (at_ != end_ && is_space(*at_)) ++at_;
  }

  /// Reads the integer that starts here. Throws InputError unless one in [least, most] does;
  /// `expected` is a function that returns the words for it, called for the error only.
  template <class Integer, class Expected>
  Integer integer(Integer least, Integer most, const Expected& expected) {
    Integer value{};
    const auto [last, error] = std::from_chars(number_start(), end_, value);
    if (error != std::errc() || !is_number_end(last) || value < least || value > most) {
      fail(expected());
    }
    at_ = last;
    return value;
  }

  /// Reads the finite number that starts here; otherwise as integer().
  template <class Expected>
  double number(const Expected& expected) {
    double value = 0;
    const char* first = number_start();
    const auto [last, error] = std::from_chars(first, end_, value);
    const bool in_range = error == std::errc() && std::isfinite(value);
    const bool too_small =
        error == std::errc::result_out_of_range && underflows(first, last, value);
    if (!(in_range || too_small) || !is_number_end(last)) fail(expected());
    at_ = last;
    return value;
  }

  /// Throws InputError about the token, or the end, that stands here.
  [[noreturn]] void fail(const std::string& expected) const;
  /// Throws InputError about what was found on this line.
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const;

 private:
  bool is_number_end(const char* at) const { return at == end_ || is_space(*at); }
  /// Past a leading '+', which from_chars does not take.
  const char* number_start() const {
    const bool plus = remaining() > 1 && *at_ == '+' && at_[1] != '-';
    return plus ? at_ + 1 : at_;
  }
  /// Whether an out-of-range literal is too small rather than too large; then `value` is its zero.
  static bool underflows(const char* first, const char* last, double& value);
  std::string describe() const;

  const char* begin_;
  const char* end_;
  const char* at_;
  std::string source_;
};

/// `text` in quotes, cut to a readable length, with bytes other than printable ASCII as \xNN.
std::string quoted(std::string_view text);

}  // namespace raybundle::io
