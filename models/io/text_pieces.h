#pragma once

#include <raybundle/linalg/parallel.h>

#include <cstdint>
#include <exception>
#include <string_view>
#include <vector>

namespace raybundle::io {

/// A stretch of a text in pieces that are read in parallel, and what stands before each: that is
/// counted first, so that every piece knows which numbers of the text are its own. The pieces
/// depend on the text alone.
class TextPieces {
 public:
  enum class Unit {
    lines,  ///< that are not blank; pieces are whole lines
    words   ///< pieces are whole words
  };

  /// Of text[first], text[first + 1] ..., all of it.
  TextPieces(std::string_view text, std::int64_t first, Unit unit, linalg::ThreadPool& pool);

  std::int64_t units() const { return before_.back(); }

  /// Calls read(first byte, first unit, last unit) for every piece. Of several that throw, the
  /// exception of the first in the text is thrown on: the one that reading in order would meet.
  template <class Read>
  void read(linalg::ThreadPool& pool, const Read& read) const {
    const auto pieces = static_cast<std::int64_t>(before_.size()) - 1;
    std::vector<std::exception_ptr> failures(before_.size());
    pool.run(pieces, [&](std::int64_t piece) {
      const auto i = static_cast<std::size_t>(piece);
      try {
        read(begin_[i], before_[i], before_[i + 1]);
      } catch (...) {
        failures[i] = std::current_exception();
      }
    });
    for (const std::exception_ptr& failure : failures) {
      if (failure) std::rethrow_exception(failure);
    }
  }

 private:
  std::vector<std::int64_t> begin_;   // byte, per piece and at the end
  std::vector<std::int64_t> before_;  // units, likewise
};

}  // namespace raybundle::io
