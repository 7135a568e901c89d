#include <raybundle/models/io/text_reader.h>

#include <algorithm>
#include <utility>

#include <raybundle/models/error.h>

namespace raybundle::io {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

TextReader::TextReader(std::string_view text, std::string source)
    : begin_(text.data()),
      end_(text.data() + text.size()),
      at_(text.data()),
      source_(std::move(source)) {}

void TextReader::fail(const std::string& expected) const { fail(describe(), expected); }

void TextReader::fail(const std::string& found, const std::string& expected) const {
  // What is missing at the end is missing after the last line that says something.
  const char* at = at_;
  if (at == end_) {
    while (at != begin_ && is_space(at[-1])) --at;
  }
  const std::int64_t line = 1 + std::count(begin_, at, '\n');
  throw InputError(source_, line, found, expected);
}

std::string TextReader::describe() const {
  if (at_end()) {
    const bool blank = std::all_of(begin_, end_, [](char c) { return is_space(c); });
    return blank ? "nothing (an empty file)" : "the end of the file";
  }
  if (at_line_end()) return "the end of the line";
  const std::string_view rest(at_, static_cast<std::size_t>(remaining()));
  if (at_ == begin_ && rest.starts_with(byte_order_mark)) return "a UTF-8 byte order mark";
  const char* last = std::find_if(at_, end_, [](char c) { return is_space(c); });
  return quoted(std::string_view(at_, static_cast<std::size_t>(last - at_)));
}

bool TextReader::underflows(const char* first, const char* last, double& value) {
  const bool negative = first != last && *first == '-';
  if (negative) ++first;

  // Decimal exponent of the first digit that is not 0, as if written d.ddd.
  constexpr std::int64_t huge = std::int64_t{1} << 60;
  std::int64_t exponent = -1;
  bool after_point = false;
  bool significant = false;
  for (; first != last && (is_digit(*first) || *first == '.'); ++first) {
    if (*first == '.') {
      after_point = true;
      continue;
    }
    significant = significant || *first != '0';
    if (significant && !after_point) ++exponent;
    if (!significant && after_point) --exponent;
  }

  if (first != last) {  // at the 'e'
    ++first;
    if (first != last && *first == '+') ++first;
    std::int64_t written = 0;
    const auto [unused, error] = std::from_chars(first, last, written);
    const bool written_negative = first != last && *first == '-';
    if (error == std::errc::result_out_of_range) written = written_negative ? -huge : huge;
    exponent += std::clamp(written, -huge, huge);
  }
  if (exponent >= 0) return false;
  value = negative ? -0.0 : 0.0;
  return true;
}

std::string quoted(std::string_view text) {
  constexpr std::size_t most = 40;
  constexpr std::string_view hex = "0123456789ABCDEF";
  std::string result = "'";
  for (const char c : text.substr(0, most)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte < 0x7F) {
      result += c;
    } else {
      result += {'\\', 'x', hex[byte / 16], hex[byte % 16]};
    }
  }
  return result + (text.size() > most ? "...'" : "'");
}

}  // namespace raybundle::io
