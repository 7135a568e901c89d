// The product of a symmetric matrix, block row by block row: each number is read once and used as
// an entry of its row and of its column. Under the rules of dense_kernels_impl.h.
#pragma once

#include <raybundle/linalg/kernels/dense_blocks_impl.h>

namespace raybundle::linalg {
namespace {

/// The same for N rows, which add to y unless they are the first.
template <int N>
void rows_both_ways(Index n, const double* A, Index stride, const double* own, const double* x,
                    double* sums, double* y, bool first) {
  constexpr auto count = static_cast<std::size_t>(N);
  Vec sum[count] = {}, factor[count];
  RAYBUNDLE_UNROLL
  for (int i = 0; i < N; ++i) factor[i] = splat(-own[i]);
  Index k = 0;
  for (; k + lanes <= n; k += lanes) {
    const Vec right = -load_unaligned(x + k);
    Vec column = first ? Vec{} : load_unaligned(y + k);
    RAYBUNDLE_UNROLL
    for (int i = 0; i < N; ++i) {
      const Vec entry = load_unaligned(A + i * stride + k);
      sum[i] = subtract_product(sum[i], right, entry);
      column = subtract_product(column, factor[i], entry);
    }
    store_unaligned(y + k, column);
  }
  RAYBUNDLE_UNROLL
  for (int i = 0; i < N; ++i) {
    for (int lane = 0; lane < lanes; ++lane) sums[i] += sum[i][lane];
  }
  for (; k < n; ++k) {
    if (first) y[k] = 0;
    for (Index i = 0; i < N; ++i) {
      sums[i] += A[i * stride + k] * x[k];
      y[k] += A[i * stride + k] * own[i];
    }
  }
}

void multiply_both_ways(Index size, Index n, const double* A, Index stride, const double* own,
                        const double* x, double* sums, double* y) {
  for (Index i = 0; i < size;) {
    const Index left = size - i;
    const Index rows = left >= 9 ? 9 : left >= 6 ? 6 : left >= 3 ? 3 : 1;
    const auto multiply = rows == 9   ? rows_both_ways<9>
                          : rows == 6 ? rows_both_ways<6>
                          : rows == 3 ? rows_both_ways<3>
                                      : rows_both_ways<1>;
    multiply(n, A + i * stride, stride, own + i, x, sums + i, y, i == 0);
    i += rows;
  }
}

}  // namespace
}  // namespace raybundle::linalg
