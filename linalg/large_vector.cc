#include <raybundle/linalg/large_vector.h>

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <cstdint>
#include <new>

namespace raybundle::linalg {
namespace {

constexpr std::size_t huge_page = std::size_t{1} << 21;

std::align_val_t alignment(std::size_t bytes) {
  constexpr std::size_t cache_line = 64;
  return std::align_val_t{bytes >= 2 * huge_page ? huge_page : cache_line};
}

}  // namespace

void* allocate_large(std::size_t bytes) {
  void* memory = ::operator new(bytes, alignment(bytes));
  advise_huge_pages(memory, bytes);
  return memory;
}

void advise_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  if (bytes < 2 * huge_page) return;
  const auto begin = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t first = (begin + huge_page - 1) / huge_page * huge_page;
  const std::uintptr_t last = (begin + bytes) / huge_page * huge_page;
  if (first < last) madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
#endif
}

void free_large(void* memory, std::size_t bytes) noexcept {
  ::operator delete(memory, alignment(bytes));
}

}  // namespace raybundle::linalg
