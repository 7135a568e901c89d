#include <raybundle/linalg/large_vector.h>

#ifdef __linux__
#include <sys/mman.h>
#endif

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
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  // Advice: where it is not taken nothing is lost.
  if (bytes >= 2 * huge_page) madvise(memory, bytes / huge_page * huge_page, MADV_HUGEPAGE);
#endif
  return memory;
}

void free_large(void* memory, std::size_t bytes) noexcept {
  ::operator delete(memory, alignment(bytes));
}

}  // namespace raybundle::linalg
