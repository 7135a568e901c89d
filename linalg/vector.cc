#include <raybundle/linalg/vector.h>

#include <array>
#include <cmath>
#include <numeric>

namespace raybundle::linalg {
namespace {

// The larger one, or NaN where there is one.
double larger(double a, double b) { return b <= a || std::isnan(a) ? a : b; }

}  // namespace

double dot(const double* u, const double* v, std::int64_t size, ThreadPool& pool) {
  return parallel_sum(pool, size, 8192, [&](std::int64_t first, std::int64_t last) {
    double sum = 0;
    for (std::int64_t i = first; i < last; ++i) sum += u[i] * v[i];
    return sum;
  });
}

double largest_magnitude(const double* x, std::int64_t size, ThreadPool& pool) {
  std::array<double, max_chunks> largest = {};
  const Chunks pieces = chunks(size, 16384);
  pool.run(pieces.pieces, [&](std::int64_t piece) {
    double most = 0;
    for (std::int64_t i = pieces.begin(piece); i < pieces.end(piece); ++i) {
      most = larger(most, std::abs(x[i]));
    }
    largest[static_cast<std::size_t>(piece)] = most;
  });
  return std::accumulate(largest.begin(), largest.end(), 0.0, larger);
}

}  // namespace raybundle::linalg
