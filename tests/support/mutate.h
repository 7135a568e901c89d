#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>

namespace raybundle::test {

/// Damages texts the way disks, editors and careless programs do. The same seed gives the same
/// damage everywhere.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  /// `text` after one to three random changes.
  std::string operator()(std::string text) {
    for (std::size_t changes = 1 + below(3); changes > 0; --changes) change(text);
    return text;
  }

 private:
  struct Range {
    std::size_t first;
    std::size_t size;
  };

  std::size_t below(std::size_t count) {
    return count == 0 ? 0 : static_cast<std::size_t>(random_() % count);
  }

  void change(std::string& text) {
    const std::size_t kind = below(13);
    if (text.empty()) return;
    const std::size_t at = below(text.size());
    switch (kind) {
      case 0:
        text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
        return;
      case 1:
        text[at] = static_cast<char>(below(256));
        return;
      case 2:
        text.insert(at, 1, odd_characters[below(odd_characters.size())]);
        return;
      case 3:
        text.erase(at, 1 + below(20));
        return;
      case 4:
        text.resize(at);
        return;
      case 5:
        duplicate_line(text, at);
        return;
      case 6:
        erase(text, line_at(text, at));
        return;
      case 7:
        swap_lines(text, at);
        return;
      case 8:
        change_digit(text, at);
        return;
      case 9:
        replace_token(text, at);
        return;
      case 10:
        replace_token(text, below(text.find('\n')));
        return;  // in the header
      case 11:
        swap_space(text, at);
        return;
      default:
        text.append(text, at, 1 + below(200));
        return;
    }
  }

  static Range line_at(const std::string& text, std::size_t at) {
    const std::size_t before = at == 0 ? std::string::npos : text.rfind('\n', at - 1);
    const std::size_t first = before == std::string::npos ? 0 : before + 1;
    const std::size_t last = std::min(text.find('\n', at), text.size() - 1);
    return {first, last - first + 1};
  }

  static void erase(std::string& text, Range range) { text.erase(range.first, range.size); }

  static void duplicate_line(std::string& text, std::size_t at) {
    const Range line = line_at(text, at);
    text.insert(line.first, text.substr(line.first, line.size));
  }

  void swap_lines(std::string& text, std::size_t at) {
    const Range line = line_at(text, at);
    const std::string content = text.substr(line.first, line.size);
    erase(text, line);
    if (!text.empty()) text.insert(line_at(text, below(text.size())).first, content);
  }

  void change_digit(std::string& text, std::size_t at) {
    const std::size_t digit = text.find_first_of("0123456789", at);
    if (digit != std::string::npos) text[digit] = static_cast<char>('0' + below(10));
  }

  void replace_token(std::string& text, std::size_t at) {
    const std::size_t first = text.find_first_not_of(" \t\r\n", at);
    if (first == std::string::npos) return;
    const std::size_t last = std::min(text.find_first_of(" \t\r\n", first), text.size());
    text.replace(first, last - first, odd_tokens[below(odd_tokens.size())]);
  }

  /// A line end for a blank or the other way round.
  static void swap_space(std::string& text, std::size_t at) {
    const std::size_t space = text.find_first_of(" \n", at);
    if (space != std::string::npos) text[space] = text[space] == ' ' ? '\n' : ' ';
  }

  static constexpr std::string_view odd_characters{"\0\t\r\n \v+-.,eE0x;#\"/\x1A\x7F\x80\xFF", 22};
  static constexpr std::array<std::string_view, 28> odd_tokens = {
      "",           "nan",        "inf",        "-inf",
      "1e999",      "-1e999",     "1e-999",     "0x1p3",
      "1,5",        "+1",         "+-1",        "-0",
      "-1",         "0",          "1",          "2",
      "3",          "1.",         ".5",         "1e",
      "--1",        "2147483647", "2147483648", "-2147483649",
      "9999999999", "1e5",        "4.9e-324",   "9223372036854775808"};

  std::mt19937_64 random_;
};

}  // namespace raybundle::test
