// The kernels of dense_kernels.h in terms of a vector of RAYBUNDLE_LANES doubles. Included by one
// file per instruction set, which defines that macro; everything lives in an anonymous namespace,
// and nothing of the standard library is called, so that no inline function compiled for one
// processor can be linked into code for another.
#pragma once

#include <cstdint>

#include <raybundle/linalg/kernels/dense_blocks_impl.h>
#include <raybundle/linalg/kernels/dense_kernels.h>
#include <raybundle/linalg/kernels/dense_rows_impl.h>
#include <raybundle/linalg/kernels/symmetric_rows_impl.h>

namespace raybundle::linalg {
namespace {

/// The columns of strip q right of its first `from` strips, as operand of a product.
RAYBUNDLE_INLINE double* strip_from(const PackedTriangle& L, Index q, Index from) {
  return strip_begin(L, q) + from * strip * strip;
}

/// Copies `height` numbers of a column into a strip and fills the rest with zeros.
RAYBUNDLE_INLINE void pack_column(const double* from, Index height, double* to) {
  if (height == strip) {
    RAYBUNDLE_UNROLL
    for (int v = 0; v < strip_vectors; ++v) store(to + v * lanes, load_unaligned(from + v * lanes));
    return;
  }
  for (Index r = 0; r < height; ++r) to[r] = from[r];
  for (Index r = height; r < strip; ++r) to[r] = 0.0;
}

RAYBUNDLE_INLINE void unpack_column(const double* from, Index height, double* to) {
  if (height == strip) {
    RAYBUNDLE_UNROLL
    for (int v = 0; v < strip_vectors; ++v) store_unaligned(to + v * lanes, load(from + v * lanes));
    return;
  }
  for (Index r = 0; r < height; ++r) to[r] = from[r];
}

/// The diagonal block of strip p, with zeros above the diagonal and the identity as padding.
void pack_diagonal(const double* A, Index ld, const PackedTriangle& L, Index p) {
  const Index top = p * strip;
  const Index height = smaller(strip, L.order - top);
  double* to = strip_begin(L, p) + top * strip;
  for (Index c = 0; c < columns_in(L, p); ++c, to += strip) {
    RAYBUNDLE_UNROLL
    for (int v = 0; v < strip_vectors; ++v) store(to + v * lanes, Vec{});
    if (c >= height) {
      to[c] = 1.0;
      continue;
    }
    const double* const from = A + (top + c) * ld + top;
    for (Index r = c; r < height; ++r) to[r] = from[r];
  }
}

void pack(const double* A, Index ld, const PackedTriangle& L, StripRange rows, StripRange columns) {
  for (Index p = rows.begin; p < rows.end; ++p) {
    const Index top = p * strip;
    const Index height = smaller(strip, L.order - top);
    double* const to = strip_begin(L, p);
    const Index right = smaller(columns.end, p) * strip;
    for (Index c = columns.begin * strip; c < right; ++c) {
      pack_column(A + c * ld + top, height, to + c * strip);
    }
    if (p < columns.end) pack_diagonal(A, ld, L, p);
  }
}

void unpack(const PackedTriangle& L, double* A, Index ld, StripRange rows, StripRange columns) {
  for (Index p = rows.begin; p < rows.end; ++p) {
    const Index top = p * strip;
    const Index height = smaller(strip, L.order - top);
    const double* const from = strip_begin(L, p);
    const Index right = smaller(columns.end, p) * strip;
    for (Index c = columns.begin * strip; c < right; ++c) {
      unpack_column(from + c * strip, height, A + c * ld + top);
    }
    if (p >= columns.end) continue;
    for (Index c = 0; c < height; ++c) {
      const double* const column = from + (top + c) * strip;
      double* const to = A + (top + c) * ld + top;
      for (Index r = c; r < height; ++r) to[r] = column[r];
    }
  }
}

void update(const PackedTriangle& L, StripRange rows, StripRange columns, StripRange inner) {
  const Index depth = (inner.end - inner.begin) * strip;
  for (Index q = columns.begin; q < columns.end; ++q) {
    for (Index j = 0; j < columns_in(L, q); j += step) {
      const double* const b = strip_from(L, q, inner.begin) + j;
      for (Index p = larger(rows.begin, q); p < rows.end; ++p) {
        const Index skipped = p == q ? j : 0;  // rows above the diagonal
        update_block(vectors_in(L, p) - static_cast<int>(skipped) / lanes,
                     strip_begin(L, p) + (q * strip + j) * strip + skipped,
                     strip_from(L, p, inner.begin) + skipped, b, depth);
      }
    }
  }
}

void solve(const PackedTriangle& L, StripRange rows, StripRange columns, Index from) {
  for (Index p = rows.begin; p < rows.end; ++p) {
    double* const strip_values = strip_begin(L, p);
    const double* const a = strip_from(L, p, from);
    for (Index q = columns.begin; q < columns.end; ++q) {
      for (Index j = 0; j < strip; j += step) {
        const Index column = q * strip + j;
        solve_block(vectors_in(L, p), strip_values + column * strip, a, strip_from(L, q, from) + j,
                    column - from * strip, strip_begin(L, q) + column * strip + j,
                    L.inverse_diagonal + column);
      }
    }
  }
}

bool factor(const PackedTriangle& L, StripRange diagonal, Index from) {
  for (Index p = diagonal.begin; p < diagonal.end; ++p) {
    solve(L, {p, p + 1}, {diagonal.begin, p}, from);
    const double* const a = strip_from(L, p, from);
    for (Index j = 0; j < columns_in(L, p); j += step) {
      const Index column = p * strip + j;
      if (!factor_block(vectors_in(L, p) - static_cast<int>(j) / lanes,
                        strip_begin(L, p) + column * strip + j, a + j, a + j, column - from * strip,
                        L.inverse_diagonal + column, L.threshold + column)) {
        return false;
      }
    }
  }
  return true;
}

constexpr int solve_columns = 8;

/// x <- T^-1 x for the lower triangle T of order `count` <= solve_columns.
RAYBUNDLE_INLINE void forward_triangle(Index count, const double* T, Index ld, double* x) {
  for (Index c = 0; c < count; ++c) {
    x[c] /= T[c * ld + c];
    for (Index r = c + 1; r < count; ++r) x[r] -= T[c * ld + r] * x[c];
  }
}

RAYBUNDLE_INLINE void backward_triangle(Index count, const double* T, Index ld, double* x) {
  for (Index c = count - 1; c >= 0; --c) {
    for (Index r = c + 1; r < count; ++r) x[c] -= T[c * ld + r] * x[r];
    x[c] /= T[c * ld + c];
  }
}

void forward(Index n, const double* A, Index ld, double* b) {
  for (Index k = 0; k < n; k += solve_columns) {
    const double* const columns = A + k * ld;
    const Index count = smaller(solve_columns, n - k);
    forward_triangle(count, columns + k, ld, b + k);
    if (count < solve_columns) return;
    Vec x[solve_columns];
    RAYBUNDLE_UNROLL
    for (int c = 0; c < solve_columns; ++c) x[c] = splat(b[k + c]);
    Index r = k + solve_columns;
    for (; r + lanes <= n; r += lanes) {
      Vec sum = load_unaligned(b + r);
      RAYBUNDLE_UNROLL
      for (int c = 0; c < solve_columns; ++c) {
        sum = subtract_product(sum, load_unaligned(columns + c * ld + r), x[c]);
      }
      store_unaligned(b + r, sum);
    }
    for (; r < n; ++r) {
      for (Index c = 0; c < solve_columns; ++c) b[r] -= columns[c * ld + r] * b[k + c];
    }
  }
}

void backward(Index n, const double* A, Index ld, double* b) {
  const Index whole = n / solve_columns * solve_columns;
  backward_triangle(n - whole, A + whole * ld + whole, ld, b + whole);
  for (Index k = whole - solve_columns; k >= 0; k -= solve_columns) {
    const double* const columns = A + k * ld;
    Vec sum[solve_columns] = {};
    Index r = k + solve_columns;
    for (; r + lanes <= n; r += lanes) {
      const Vec x = load_unaligned(b + r);
      RAYBUNDLE_UNROLL
      for (int c = 0; c < solve_columns; ++c) {
        sum[c] = subtract_product(sum[c], load_unaligned(columns + c * ld + r), x);
      }
    }
    RAYBUNDLE_UNROLL
    for (int c = 0; c < solve_columns; ++c) {
      for (int lane = 0; lane < lanes; ++lane) b[k + c] += sum[c][lane];
      for (Index tail = r; tail < n; ++tail) b[k + c] -= columns[c * ld + tail] * b[tail];
    }
    backward_triangle(solve_columns, columns + k, ld, b + k);
  }
}

constexpr DenseKernels kernels{instructions,
                               strip,
                               step,
                               pack,
                               unpack,
                               update,
                               solve,
                               factor,
                               solve_rows,
                               subtract_squares,
                               forward_rows,
                               backward_rows,
                               multiply_both_ways,
                               forward,
                               backward};

}  // namespace
}  // namespace raybundle::linalg
