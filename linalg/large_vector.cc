#include <raybundle/linalg/large_vector.h>

#include <raybundle/linalg/huge_pages.h>
#include <raybundle/linalg/sanitized.h>

#include <new>

namespace raybundle::linalg {
namespace {

constexpr std::align_val_t cache_line{HugePages::granularity};

// A sanitizer sees the ends of what has been allocated by itself.
constexpr bool shares_huge_pages(std::size_t bytes) {
  return !sanitized && bytes >= std::size_t{1} << 15;
}

}  // namespace

void* allocate_large(std::size_t bytes) {
  return shares_huge_pages(bytes) ? huge_pages().take(bytes) : ::operator new(bytes, cache_line);
}

void free_large(void* memory, std::size_t bytes) noexcept {
  if (shares_huge_pages(bytes)) return huge_pages().give(memory, bytes);
  ::operator delete(memory, cache_line);
}

}  // namespace raybundle::linalg
