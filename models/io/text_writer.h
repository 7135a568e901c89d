#pragma once

#include <charconv>
#include <cstddef>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

namespace raybundle::io {

/// Formats numbers into large pieces of text, each handed to `sink`: doubles as the shortest
/// decimals that read back to the same bits, the same in every locale.
class TextWriter {
 public:
  explicit TextWriter(std::function<void(std::string_view)> sink)
      : sink_(std::move(sink)), buffer_(capacity) {}

  /// A number (a double or an integer) and the character after it.
  template <class Number>
  void number(Number value, char separator) {
    if (capacity - size_ < longest) flush();
    char* first = buffer_.data() + size_;
    char* last = std::to_chars(first, buffer_.data() + capacity, value).ptr;
    *last++ = separator;
    size_ += static_cast<std::size_t>(last - first);
  }

  /// Hands over what has been collected. To be called at the end: the destructor does not, since
  /// a sink may throw.
  void flush() {
    sink_(std::string_view(buffer_.data(), size_));
    size_ = 0;
  }

 private:
  static constexpr std::size_t capacity = std::size_t{1} << 17;
  static constexpr std::size_t longest = 64;  // no shortest double or 64-bit integer is longer

  std::function<void(std::string_view)> sink_;
  std::vector<char> buffer_;
  std::size_t size_ = 0;
};

}  // namespace raybundle::io
