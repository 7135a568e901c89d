#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace raybundle::linalg {

/// Memory that is not cleared, from some kilobytes on in huge pages: the arrays of a large
/// problem are written before they are read, by the threads that need them, and are then gone
/// through in an order that would miss the small pages' translations all the time.
/// Throws std::bad_alloc.
void* allocate_large(std::size_t bytes);
void free_large(void* memory, std::size_t bytes) noexcept;

template <class T>
struct LargeAllocator {
  using value_type = T;  // NOLINT(readability-identifier-naming): as allocators are asked for it

  LargeAllocator() = default;
  template <class Other>
  explicit LargeAllocator(const LargeAllocator<Other>& /*other*/) {}

  T* allocate(std::size_t count) { return static_cast<T*>(allocate_large(count * sizeof(T))); }
  void deallocate(T* memory, std::size_t count) noexcept { free_large(memory, count * sizeof(T)); }
  /// Without a value: what the memory holds.
  template <class Other>
  void construct(Other* at) {
    ::new (static_cast<void*>(at)) Other;
  }
  template <class Other, class... Values>
  void construct(Other* at, Values&&... values) {
    std::construct_at(at, std::forward<Values>(values)...);
  }
  bool operator==(const LargeAllocator& /*other*/) const { return true; }
};

/// A vector whose elements have any value until they are written.
template <class T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

}  // namespace raybundle::linalg
