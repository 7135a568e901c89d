#pragma once

#include <cstddef>
#include <mutex>
#include <vector>

namespace raybundle::linalg {

/// Memory in huge pages of the system, shared by the arrays of a problem. The first touch of a
/// small page is a fault, which takes longer than to fill the page, in a virtual machine many times
/// longer; and huge pages of its own would leave every array with an empty end. Ranges are taken
/// first-fit from what is free; whole huge pages that are free again go back to the system. Safe to
/// use from several threads.
class HugePages {
 public:
  static constexpr std::size_t page = std::size_t{1} << 21;  ///< bytes
  static constexpr std::size_t granularity = 64;             ///< a cache line: alignment of ranges

  /// Not cleared, at least of 1 byte. Throws std::bad_alloc.
  void* take(std::size_t bytes);
  /// `bytes` as they were taken.
  void give(void* memory, std::size_t bytes) noexcept;

  /// Bytes of all ranges that are free and yet held.
  std::size_t held() const;

 private:
  struct Range {
    char* begin;
    std::size_t bytes;
    char* end() const { return begin + bytes; }
  };

  void make_room_for_another();
  void* take_first_fit(std::size_t bytes);
  void grow(std::size_t bytes);
  void add(char* begin, std::size_t bytes);
  void insert(Range range) noexcept;
  void release_whole_pages() noexcept;

  mutable std::mutex mutex_;
  // What is free, in the order of addresses; no two ranges touch. Told beside the memory and not in
  // it: to touch a page is work, which belongs to the threads that fill it.
  std::vector<Range> free_;
  std::size_t taken_ = 0;
};

/// Those of the process.
HugePages& huge_pages();

/// Asks for huge pages within memory of another origin, which nothing has been written to yet;
/// advice, which may not be taken.
void advise_huge_pages(void* memory, std::size_t bytes);

}  // namespace raybundle::linalg
