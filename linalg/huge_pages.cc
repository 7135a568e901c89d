#include <raybundle/linalg/huge_pages.h>

#include <sys/mman.h>

#include <cstdint>
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
  if (void* found = take_first_fit(rounded)) return found;
  grow(rounded);
  return take_first_fit(rounded);
}

// From the end of a range, so that what is left of it can grow downwards, as mappings do.
void* HugePages::take_first_fit(std::size_t bytes) {
  Range* before = &first_;
  while (before->next && before->next->bytes < bytes) before = before->next;
  Range* const found = before->next;
  if (!found) return nullptr;
  if (found->bytes == bytes) before->next = found->next;
  found->bytes -= bytes;
  return end(found);
}

// Below the lowest range that is free, which is then a part of it, if nothing else is there.
void HugePages::grow(std::size_t bytes) {
  if (Range* lowest = first_.next; lowest && address(lowest) % page == 0) {
    const std::size_t missing = round_up(bytes - lowest->bytes, page);
    char* const below = reinterpret_cast<char*>(lowest) - missing;
    if (missing < address(lowest) && map(missing, below)) return add(below, missing);
  }
  const std::size_t missing = round_up(bytes, page);
  add(map_aligned(missing), missing);
}

void HugePages::add(char* begin, std::size_t bytes) {
  advise_huge_pages(begin, bytes);
  insert(begin, bytes);
}

void HugePages::give(void* memory, std::size_t bytes) noexcept {
  const std::lock_guard lock(mutex_);
  insert(static_cast<char*>(memory), round_up(bytes, granularity));
  release_whole_pages();
}

// Joined with the ranges that it touches.
void HugePages::insert(char* begin, std::size_t bytes) noexcept {
  Range* before = &first_;
  while (before->next && address(before->next) < address(begin)) before = before->next;
  Range* range = before;
  if (before != &first_ && end(before) == begin) {
    range->bytes += bytes;
  } else {
    range = before->next = ::new (begin) Range{bytes, before->next};
  }
  const Range* const after = range->next;
  if (after && end(range) == reinterpret_cast<const char*>(after)) {
    range->bytes += after->bytes;
    range->next = after->next;
  }
}

void HugePages::release_whole_pages() noexcept {
  for (Range* before = &first_; before->next;) {
    Range* const range = before->next;
    char* const from = next_page(reinterpret_cast<char*>(range));
    char* const to = page_of(end(range));
    if (from >= to) {
      before = range;
      continue;
    }
    Range* rest = range->next;
    if (to < end(range)) rest = ::new (to) Range{static_cast<std::size_t>(end(range) - to), rest};
    const auto left = static_cast<std::size_t>(from - reinterpret_cast<char*>(range));
    if (left > 0) {
      *range = {left, rest};
      before = range;
    } else {
      before->next = rest;
    }
    unmap(from, to);
  }
}

std::size_t HugePages::held() const {
  const std::lock_guard lock(mutex_);
  std::size_t bytes = 0;
  for (const Range* range = first_.next; range; range = range->next) bytes += range->bytes;
  return bytes;
}

HugePages& huge_pages() {
  static HugePages pages;
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
