#include <raybundle/models/io/text_pieces.h>

#include <raybundle/models/io/text_reader.h>

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace raybundle::io {
namespace {

std::int64_t count_lines(std::string_view text) {
  std::int64_t lines = 0;
  while (!text.empty()) {
    const std::size_t length = std::min(text.find('\n'), text.size() - 1) + 1;
    lines += std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(length), is_space)
                 ? 0
                 : 1;
    text.remove_prefix(length);
  }
  return lines;
}

std::int64_t count_words(std::string_view text) {
  std::int64_t words = text.empty() || is_space(text[0]) ? 0 : 1;
  for (std::size_t i = 1; i < text.size(); ++i) {
    words += static_cast<int>(is_space(text[i - 1])) & static_cast<int>(!is_space(text[i]));
  }
  return words;
}

}  // namespace

TextPieces::TextPieces(std::string_view text, std::int64_t first, Unit unit,
                       linalg::ThreadPool& pool) {
  constexpr std::int64_t grain = std::int64_t{1} << 18;
  const auto size = static_cast<std::int64_t>(text.size());
  const auto divides = [&](char c) { return unit == Unit::lines ? c == '\n' : is_space(c); };
  const linalg::Chunks pieces = linalg::chunks(size - first, grain);
  begin_ = {first};
  for (std::int64_t i = 1; i < pieces.pieces; ++i) {
    const std::int64_t wanted = std::max(first + pieces.begin(i), begin_.back());
    begin_.push_back(std::find_if(text.begin() + wanted, text.end(), divides) - text.begin());
  }
  begin_.push_back(size);
  before_.assign(begin_.size(), 0);
  pool.run(static_cast<std::int64_t>(begin_.size()) - 1, [&](std::int64_t piece) {
    const auto i = static_cast<std::size_t>(piece);
    const std::string_view own = text.substr(static_cast<std::size_t>(begin_[i]),
                                             static_cast<std::size_t>(begin_[i + 1] - begin_[i]));
    before_[i + 1] = unit == Unit::lines ? count_lines(own) : count_words(own);
  });
  std::partial_sum(before_.begin(), before_.end(), before_.begin());
}

}  // namespace raybundle::io
