// The kernels on the rows below a packed triangle and on what they leave (PackedRows): what a
// front of the supernodal factorisation is made of. Under the rules of dense_kernels_impl.h.
#pragma once

#include <raybundle/linalg/kernels/dense_blocks_impl.h>

namespace raybundle::linalg {
namespace {

RAYBUNDLE_INLINE double* strip_begin(const PackedRows& R, Index p) {
  return R.values + p * strip * R.columns;
}

RAYBUNDLE_INLINE Index strips_in(const PackedTriangle& L) { return (L.order + strip - 1) / strip; }

/// Columns [first, last) of the rows, whose columns before are done.
void solve_slice(const PackedTriangle& L, const PackedRows& R, StripRange rows, Index first,
                 Index last) {
  for (Index k = 0; k < first; k += slice_columns) {
    for (Index column = first; column < last; column += step) {
      const double* const b = strip_begin(L, column / strip) + k * strip + column % strip;
      for (Index p = rows.begin; p < rows.end; ++p) {
        double* const x = strip_begin(R, p);
        update_block<strip_vectors>(x + column * strip, x + k * strip, b, slice_columns);
      }
    }
  }
  for (Index column = first; column < last; column += step) {
    const double* const b = strip_begin(L, column / strip) + column % strip;
    for (Index p = rows.begin; p < rows.end; ++p) {
      double* const x = strip_begin(R, p);
      solve_block<strip_vectors>(x + column * strip, x + first * strip, b + first * strip,
                                 column - first, b + column * strip, L.inverse_diagonal + column);
    }
  }
}

void solve_rows(const PackedTriangle& L, const PackedRows& R, StripRange rows) {
  for (Index first = 0; first < R.columns; first += slice_columns) {
    solve_slice(L, R, rows, first, smaller(first + slice_columns, R.columns));
  }
}

void subtract_squares(const PackedTriangle& C, const PackedRows& R, StripRange rows,
                      StripRange columns) {
  for (Index k = 0; k < R.columns; k += slice_columns) {
    const Index depth = smaller(slice_columns, R.columns - k);
    for (Index q = columns.begin; q < columns.end; ++q) {
      for (Index j = 0; j < columns_in(C, q); j += step) {
        const double* const b = strip_begin(R, q) + k * strip + j;
        for (Index p = larger(rows.begin, q); p < rows.end; ++p) {
          const Index skipped = p == q ? j : 0;  // rows above the diagonal
          update_block(vectors_in(C, p) - static_cast<int>(skipped) / lanes,
                       strip_begin(C, p) + (q * strip + j) * strip + skipped,
                       strip_begin(R, p) + k * strip + skipped, b, depth);
        }
      }
    }
  }
}

/// y -= A x for a strip A of so many columns.
RAYBUNDLE_INLINE void subtract_strip(const double* A, Index columns, const double* x, double* y) {
  Vec sum[strip_vectors];
  RAYBUNDLE_UNROLL
  for (int v = 0; v < strip_vectors; ++v) sum[v] = load_unaligned(y + v * lanes);
  for (Index k = 0; k < columns; ++k, A += strip) {
    const Vec factor = splat(x[k]);
    RAYBUNDLE_UNROLL
    for (int v = 0; v < strip_vectors; ++v) {
      sum[v] = subtract_product(sum[v], load(A + v * lanes), factor);
    }
  }
  RAYBUNDLE_UNROLL
  for (int v = 0; v < strip_vectors; ++v) store_unaligned(y + v * lanes, sum[v]);
}

/// x[c] -= column c of A times y, for `step` columns of strips `apart` from one another.
RAYBUNDLE_INLINE void subtract_columns(const double* A, Index apart, Index strips, const double* y,
                                       double* x) {
  Vec sum[step] = {};
  for (Index p = 0; p < strips; ++p, A += apart, y += strip) {
    RAYBUNDLE_UNROLL
    for (int v = 0; v < strip_vectors; ++v) {
      const Vec factor = load_unaligned(y + v * lanes);
      RAYBUNDLE_UNROLL
      for (int c = 0; c < step; ++c) {
        sum[c] = subtract_product(sum[c], load(A + c * strip + v * lanes), factor);
      }
    }
  }
  RAYBUNDLE_UNROLL
  for (int c = 0; c < step; ++c) {
    for (int lane = 0; lane < lanes; ++lane) x[c] += sum[c][lane];
  }
}

void forward_rows(const PackedTriangle& L, const PackedRows& R, Index strips, double* x,
                  double* y) {
  for (Index p = 0; p < strips_in(L); ++p) {
    double* const own = x + p * strip;
    const double* T = strip_begin(L, p);
    subtract_strip(T, p * strip, x, own);
    T += p * strip * strip;
    for (Index c = 0; c < columns_in(L, p); ++c) {
      own[c] *= L.inverse_diagonal[p * strip + c];
      for (Index r = c + 1; r < columns_in(L, p); ++r) own[r] -= T[c * strip + r] * own[c];
    }
  }
  for (Index p = 0; p < strips; ++p, y += strip) {
    RAYBUNDLE_UNROLL
    for (int v = 0; v < strip_vectors; ++v) store_unaligned(y + v * lanes, Vec{});
    subtract_strip(strip_begin(R, p), R.columns, x, y);
  }
}

void backward_rows(const PackedTriangle& L, const PackedRows& R, Index strips, double* x,
                   const double* y) {
  for (Index k = 0; k < R.columns; k += step) {
    subtract_columns(R.values + k * strip, R.columns * strip, strips, y, x + k);
  }
  for (Index p = strips_in(L) - 1; p >= 0; --p) {
    double* const own = x + p * strip;
    const double* const T = strip_begin(L, p);
    const double* const diagonal = T + p * strip * strip;
    for (Index c = columns_in(L, p) - 1; c >= 0; --c) {
      for (Index r = c + 1; r < columns_in(L, p); ++r) own[c] -= diagonal[c * strip + r] * own[r];
      own[c] *= L.inverse_diagonal[p * strip + c];
    }
    for (Index k = 0; k < p * strip; k += step) {
      subtract_columns(T + k * strip, 0, 1, own, x + k);
    }
  }
}

}  // namespace
}  // namespace raybundle::linalg
