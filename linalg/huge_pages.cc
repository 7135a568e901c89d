#include <raybundle/linalg/huge_pages.h>

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <new>

namespace raybundle::linalg {
namespace {

constexpr std::size_t round_up(std::size_t bytes, std::size_t to) {
  return (bytes + to - 1) / to * to;
}

std::uintptr_t address(const void* memory) { return reinterpret_cast<std::uintptr_t>(memory); }

char* next_page(char* at) { return at + (round_up(address(at), HugePages::page) - address(at)); }

char* page_of(char* at) { return at - address(at) % HugePages::page; }

void unmap(char* begin, const char* end) {
  if (begin < end) ::munmap(begin, static_cast<std::size_t>(end - begin));
}

// Wherever there is room, or just there; null if there is none.
char* map(std::size_t bytes, char* at = nullptr) {
  constexpr int kind = MAP_PRIVATE | MAP_ANONYMOUS;
  void* const mapping = ::mmap(at, bytes, PROT_READ | PROT_WRITE, kind, -1, 0);
  if (mapping == MAP_FAILED) return nullptr;
  char* const begin = static_cast<char*>(mapping);
  if (!at || begin == at) return begin;
  unmap(begin, begin + bytes);
  return nullptr;
}

// From the start of a huge page on; `bytes` is a multiple of its size.
char* map_aligned(std::size_t bytes) {
  const std::size_t more = bytes + HugePages::page;
  char* const mapping = more < bytes ? nullptr : map(more);
  if (!mapping) throw std::bad_alloc();
  char* const begin = next_page(mapping);
  unmap(mapping, begin);
  unmap(begin + bytes, mapping + more);
  return begin;
}

}  // namespace

void* HugePages::take(std::size_t bytes) {
  const std::size_t rounded = round_up(bytes, granularity);
  if (rounded < bytes || round_up(rounded, page) < rounded) throw std::bad_alloc();
  const std::lock_guard lock(mutex_);
  make_room_for_another();
  void* found = take_first_fit(rounded);
  if (!found) {
    grow(rounded);
    found = take_first_fit(rounded);
  }
  ++taken_;
  return found;
}

// So that give() need not allocate. Every range that is free adjoins one that is taken, since whole
// pages are not kept: there are at most two for each of these, and for a moment the one that is
// given, which the pages that go may split.
void HugePages::make_room_for_another() {
  const std::size_t most = 2 * (taken_ + 1) + 2;
  if (free_.capacity() < most) free_.reserve(2 * most);
}

// From the end of a range, so that what is left of it can grow downwards, as mappings do.
void* HugePages::take_first_fit(std::size_t bytes) {
  const auto found = std::find_if(free_.begin(), free_.end(),
                                  [&](const Range& range) { return range.bytes >= bytes; });
  if (found == free_.end()) return nullptr;
  found->bytes -= bytes;
  char* const taken = found->end();
  if (found->bytes == 0) free_.erase(found);
  return taken;
}

// Below the lowest range that is free, which is then a part of it, if nothing else is there.
void HugePages::grow(std::size_t bytes) {
  if (!free_.empty() && address(free_.front().begin) % page == 0) {
    const Range lowest = free_.front();
    const std::size_t missing = round_up(bytes - lowest.bytes, page);
    char* const below = lowest.begin - missing;
    if (missing < address(lowest.begin) && map(missing, below)) return add(below, missing);
  }
  const std::size_t missing = round_up(bytes, page);
  add(map_aligned(missing), missing);
}

void HugePages::add(char* begin, std::size_t bytes) {
  advise_huge_pages(begin, bytes);
  insert({begin, bytes});
}

void HugePages::give(void* memory, std::size_t bytes) noexcept {
  const std::lock_guard lock(mutex_);
  insert({static_cast<char*>(memory), round_up(bytes, granularity)});
  release_whole_pages();
  --taken_;
}

// Joined with the ranges that it touches.
void HugePages::insert(Range range) noexcept {
  auto after = std::find_if(free_.begin(), free_.end(),
                            [&](const Range& each) { return each.begin > range.begin; });
  if (after != free_.begin() && std::prev(after)->end() == range.begin) {
    range = {std::prev(after)->begin, std::prev(after)->bytes + range.bytes};
    after = free_.erase(std::prev(after));
  }
  if (after != free_.end() && range.end() == after->begin) {
    *after = {range.begin, range.bytes + after->bytes};
  } else {
    free_.insert(after, range);
  }
}

void HugePages::release_whole_pages() noexcept {
  for (std::size_t i = free_.size(); i-- > 0;) {
    const Range range = free_[i];
    char* const from = next_page(range.begin);
    char* const to = page_of(range.end());
    if (from >= to) continue;
    unmap(from, to);
    const Range left = {range.begin, static_cast<std::size_t>(from - range.begin)};
    const Range right = {to, static_cast<std::size_t>(range.end() - to)};
    auto at = free_.erase(free_.begin() + static_cast<std::ptrdiff_t>(i));
    if (right.bytes > 0) at = free_.insert(at, right);
    if (left.bytes > 0) free_.insert(at, left);
  }
}

std::size_t HugePages::held() const {
  const std::lock_guard lock(mutex_);
  std::size_t bytes = 0;
  for (const Range& range : free_) bytes += range.bytes;
  return bytes;
}

// Never destroyed: arrays may be given back when the program ends.
HugePages& huge_pages() {
  static HugePages& pages = *new HugePages;
  return pages;
}

void advise_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#ifdef MADV_HUGEPAGE
  char* const from = next_page(static_cast<char*>(memory));
  char* const to = page_of(static_cast<char*>(memory) + bytes);
  if (from < to) ::madvise(from, static_cast<std::size_t>(to - from), MADV_HUGEPAGE);
#endif
}

}  // namespace raybundle::linalg
