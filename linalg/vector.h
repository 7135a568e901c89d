#pragma once

#include <raybundle/linalg/parallel.h>

#include <cstddef>
#include <cstdint>

namespace raybundle::linalg {

/// u . v with the same bits for any number of threads.
double dot(const double* u, const double* v, std::int64_t size, ThreadPool& pool);

/// The largest |x_i|; NaN where one is.
double largest_magnitude(const double* x, std::int64_t size, ThreadPool& pool);

/// Calls update(i) for every entry of a vector, in parallel.
template <class Update>
void for_entries(std::int64_t size, ThreadPool& pool, Update&& update) {
  parallel_for(pool, size, 16384, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) update(static_cast<std::size_t>(i));
  });
}

}  // namespace raybundle::linalg
