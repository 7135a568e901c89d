#include <raybundle/linalg/vector.h>

namespace raybundle::linalg {

double dot(const double* u, const double* v, std::int64_t size, ThreadPool& pool) {
  return parallel_sum(pool, size, 8192, [&](std::int64_t first, std::int64_t last) {
    double sum = 0;
    for (std::int64_t i = first; i < last; ++i) sum += u[i] * v[i];
    return sum;
  });
}

}  // namespace raybundle::linalg
