// Vectors of RAYBUNDLE_LANES doubles and the arithmetic on blocks that fit in registers: the inner
// part of dense_kernels_impl.h, under the same rules.
#pragma once

#include <cstddef>
#include <cstdint>

#if RAYBUNDLE_LANES > 2
#include <immintrin.h>
#endif

#include <raybundle/linalg/kernels/dense_kernels.h>

#define RAYBUNDLE_INLINE __attribute__((always_inline)) inline
#define RAYBUNDLE_UNROLL _Pragma("GCC unroll 32")

namespace raybundle::linalg {
namespace {

using Index = std::int64_t;

constexpr int lanes = RAYBUNDLE_LANES;
using Vec [[gnu::vector_size(8 * lanes)]] = double;
using UnalignedVec [[gnu::vector_size(8 * lanes), gnu::aligned(8), gnu::may_alias]] = double;

#if RAYBUNDLE_LANES == 8
constexpr InstructionSet instructions = InstructionSet::avx512;
constexpr int strip_vectors = 3;
constexpr int step = 8;
RAYBUNDLE_INLINE Vec splat(double s) { return _mm512_set1_pd(s); }
RAYBUNDLE_INLINE Vec subtract_product(Vec c, Vec a, Vec b) { return _mm512_fnmadd_pd(a, b, c); }
RAYBUNDLE_INLINE Vec square_root(Vec v) { return _mm512_maskz_sqrt_pd(0xff, v); }
#elif RAYBUNDLE_LANES == 4
constexpr InstructionSet instructions = InstructionSet::avx2;
constexpr int strip_vectors = 3;
constexpr int step = 4;
RAYBUNDLE_INLINE Vec splat(double s) { return _mm256_set1_pd(s); }
RAYBUNDLE_INLINE Vec subtract_product(Vec c, Vec a, Vec b) { return _mm256_fnmadd_pd(a, b, c); }
RAYBUNDLE_INLINE Vec square_root(Vec v) { return _mm256_sqrt_pd(v); }
#else
constexpr InstructionSet instructions = InstructionSet::baseline;
constexpr int strip_vectors = 2;
constexpr int step = 4;
RAYBUNDLE_INLINE Vec splat(double s) { return Vec{s, s}; }
RAYBUNDLE_INLINE Vec subtract_product(Vec c, Vec a, Vec b) { return c - a * b; }
RAYBUNDLE_INLINE Vec square_root(Vec v) { return Vec{__builtin_sqrt(v[0]), __builtin_sqrt(v[1])}; }
#endif

constexpr Index strip = strip_vectors * lanes;

static_assert(strip % step == 0 && step % lanes == 0);
static_assert(strip <= widest_strip && step <= widest_step && slice_columns % strip == 0);
static_assert(lanes < 8 || (strip == widest_strip && step == widest_step));

RAYBUNDLE_INLINE Vec load(const double* p) { return *reinterpret_cast<const Vec*>(p); }
RAYBUNDLE_INLINE Vec load_unaligned(const double* p) {
  return *reinterpret_cast<const UnalignedVec*>(p);
}
RAYBUNDLE_INLINE void store(double* p, Vec v) { *reinterpret_cast<Vec*>(p) = v; }
RAYBUNDLE_INLINE void store_unaligned(double* p, Vec v) { *reinterpret_cast<UnalignedVec*>(p) = v; }

RAYBUNDLE_INLINE Index smaller(Index a, Index b) { return a < b ? a : b; }
RAYBUNDLE_INLINE Index larger(Index a, Index b) { return a > b ? a : b; }

/// The first number of strip p.
RAYBUNDLE_INLINE double* strip_begin(const PackedTriangle& L, Index p) {
  return L.values + strip * strip / 2 * p * (p + 1);
}

/// Vectors of strip p that hold rows of the (padded) matrix.
RAYBUNDLE_INLINE int vectors_in(const PackedTriangle& L, Index p) {
  const Index padded = (L.order + step - 1) / step * step;
  return static_cast<int>(smaller(strip, padded - p * strip) / lanes);
}

/// Columns of strip p that belong to the (padded) matrix.
RAYBUNDLE_INLINE Index columns_in(const PackedTriangle& L, Index p) {
  const Index padded = (L.order + step - 1) / step * step;
  return smaller(strip, padded - p * strip);
}

/// A block of V vectors (of rows) by `step` columns held in registers.
template <int V>
struct Block {
  Vec x[step][static_cast<std::size_t>(V)];
};

template <int V>
RAYBUNDLE_INLINE void load_block(Block<V>& block, const double* c) {
  RAYBUNDLE_UNROLL
  for (int j = 0; j < step; ++j) {
    RAYBUNDLE_UNROLL
    for (int v = 0; v < V; ++v) block.x[j][v] = load(c + j * strip + v * lanes);
  }
}

template <int V>
RAYBUNDLE_INLINE void store_block(const Block<V>& block, double* c) {
  RAYBUNDLE_UNROLL
  for (int j = 0; j < step; ++j) {
    RAYBUNDLE_UNROLL
    for (int v = 0; v < V; ++v) store(c + j * strip + v * lanes, block.x[j][v]);
  }
}

/// block -= A B^T over `depth` columns of two strips; a and b point to their first rows.
template <int V>
RAYBUNDLE_INLINE void subtract_products(Block<V>& block, const double* a, const double* b,
                                        Index depth) {
  for (Index k = 0; k < depth; ++k, a += strip, b += strip) {
    Vec left[static_cast<std::size_t>(V)];
    RAYBUNDLE_UNROLL
    for (int v = 0; v < V; ++v) left[v] = load(a + v * lanes);
    RAYBUNDLE_UNROLL
    for (int j = 0; j < step; ++j) {
      const Vec right = splat(b[j]);
      RAYBUNDLE_UNROLL
      for (int v = 0; v < V; ++v) block.x[j][v] = subtract_product(block.x[j][v], left[v], right);
    }
  }
}

/// c -= A B^T.
template <int V>
void update_block(double* c, const double* a, const double* b, Index depth) {
  Block<V> block;
  load_block(block, c);
  subtract_products(block, a, b, depth);
  store_block(block, c);
}

/// c <- (c - A B^T) T^-T with the lower triangular `step` x `step` block T (columns `strip` apart).
template <int V>
void solve_block(double* c, const double* a, const double* b, Index depth, const double* triangle,
                 const double* inverse_diagonal) {
  Block<V> block;
  load_block(block, c);
  subtract_products(block, a, b, depth);
  RAYBUNDLE_UNROLL
  for (int k = 0; k < step; ++k) {
    const Vec inverse = splat(inverse_diagonal[k]);
    RAYBUNDLE_UNROLL
    for (int v = 0; v < V; ++v) block.x[k][v] *= inverse;
    RAYBUNDLE_UNROLL
    for (int j = k + 1; j < step; ++j) {
      const Vec factor = splat(triangle[k * strip + j]);
      RAYBUNDLE_UNROLL
      for (int v = 0; v < V; ++v) {
        block.x[j][v] = subtract_product(block.x[j][v], block.x[k][v], factor);
      }
    }
  }
  store_block(block, c);
}

/// Factorises `step` columns of a strip from their diagonal down, after subtracting A B^T. Works as
/// L D L^T, to keep the square roots off the chain of pivots, and scales at the end.
template <int V>
bool factor_block(double* c, const double* a, const double* b, Index depth,
                  double* inverse_diagonal, const double* threshold) {
  Block<V> block;
  load_block(block, c);
  subtract_products(block, a, b, depth);
  alignas(8 * lanes) double pivots[step];
  RAYBUNDLE_UNROLL
  for (int k = 0; k < step; ++k) {
    pivots[k] = block.x[k][k / lanes][k % lanes];
    const Vec inverse = splat(1.0 / pivots[k]);
    Vec multipliers[step / lanes];
    RAYBUNDLE_UNROLL
    for (int v = k / lanes; v < step / lanes; ++v) multipliers[v] = block.x[k][v] * inverse;
    RAYBUNDLE_UNROLL
    for (int j = k + 1; j < step; ++j) {
      const Vec factor = splat(multipliers[j / lanes][j % lanes]);
      RAYBUNDLE_UNROLL
      for (int v = 0; v < V; ++v) {
        block.x[j][v] = subtract_product(block.x[j][v], block.x[k][v], factor);
      }
    }
  }
  RAYBUNDLE_UNROLL
  for (int v = 0; v < step / lanes; ++v) {
    store_unaligned(inverse_diagonal + v * lanes,
                    splat(1.0) / square_root(load(pivots + v * lanes)));
  }
  bool positive = true;
  RAYBUNDLE_UNROLL
  for (int k = 0; k < step; ++k) {
    positive &= pivots[k] > threshold[k] && pivots[k] < __DBL_MAX__ && pivots[k] > __DBL_MIN__;
    const Vec scale = splat(inverse_diagonal[k]);
    RAYBUNDLE_UNROLL
    for (int v = 0; v < V; ++v) block.x[k][v] *= scale;
  }
  store_block(block, c);
  return positive;
}

/// The same for the number of vectors a strip has.
RAYBUNDLE_INLINE void update_block(int vectors, double* c, const double* a, const double* b,
                                   Index depth) {
  if (vectors == 3) {
    update_block<3>(c, a, b, depth);
  } else if (vectors == 2) {
    update_block<2>(c, a, b, depth);
  } else {
    update_block<1>(c, a, b, depth);
  }
}

RAYBUNDLE_INLINE void solve_block(int vectors, double* c, const double* a, const double* b,
                                  Index depth, const double* triangle, const double* inverse) {
  if (vectors == 3) {
    solve_block<3>(c, a, b, depth, triangle, inverse);
  } else if (vectors == 2) {
    solve_block<2>(c, a, b, depth, triangle, inverse);
  } else {
    solve_block<1>(c, a, b, depth, triangle, inverse);
  }
}

RAYBUNDLE_INLINE bool factor_block(int vectors, double* c, const double* a, const double* b,
                                   Index depth, double* inverse, const double* threshold) {
  constexpr int least = step / lanes;
  if constexpr (strip_vectors == 3) {
    if (vectors == 3) return factor_block<3>(c, a, b, depth, inverse, threshold);
  }
  if (vectors == 2) return factor_block<2>(c, a, b, depth, inverse, threshold);
  return factor_block<least>(c, a, b, depth, inverse, threshold);
}

}  // namespace
}  // namespace raybundle::linalg
