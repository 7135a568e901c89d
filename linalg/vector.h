#pragma once

#include <raybundle/linalg/parallel.h>

#include <cstdint>

namespace raybundle::linalg {

/// u . v with the same bits for any number of threads.
double dot(const double* u, const double* v, std::int64_t size, ThreadPool& pool);

}  // namespace raybundle::linalg
