// Numbers of several observations side by side, one in each lane of a vector register, and how they
// get there from rows of numbers in memory and back: by whole loads and stores and a transposition
// in registers, since gather instructions fetch one number at a time (docs/decisions.md). Included
// by the kernel units only; the compiler's vectors are lowered to whatever the unit is compiled for
// (linalg/kernels/row.h has those of the linear algebra).

#pragma once

#include <cstdint>
#include <utility>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

#if defined(__AVX512F__)
constexpr int lanes = 8;
#elif defined(__AVX2__)
constexpr int lanes = 4;
#else
constexpr int lanes = 2;
#endif

using Vector2 [[gnu::vector_size(16)]] = double;
using Vector4 [[gnu::vector_size(32)]] = double;
using Vector8 [[gnu::vector_size(64)]] = double;
using Lanes [[gnu::vector_size(8 * lanes)]] = double;
using LaneIndices [[gnu::vector_size(8 * lanes)]] = std::int64_t;

template <int n>
using Sequence = std::make_integer_sequence<int, n>;
template <int... i>
using Indices = std::integer_sequence<int, i...>;

template <class Vector>
[[gnu::always_inline]] inline Vector load(const double* x) {
  Vector v;
  __builtin_memcpy(&v, x, sizeof(v));
  return v;
}
template <class Vector>
[[gnu::always_inline]] inline void store(Vector v, double* x) {
  __builtin_memcpy(x, &v, sizeof(v));
}

// Numbers of a for each even place and of b for each odd one: those at even places (offset 0) or at
// odd ones (offset 1).
template <int offset, int... i>
[[gnu::always_inline]] inline Lanes alternate(Lanes a, Lanes b, Indices<i...> /*of lanes*/) {
  return __builtin_shufflevector(a, b, (i / 2 * 2 + offset + i % 2 * lanes)...);
}
[[gnu::always_inline]] inline Lanes even(Lanes a, Lanes b) {
  return alternate<0>(a, b, Sequence<lanes>{});
}
[[gnu::always_inline]] inline Lanes odd(Lanes a, Lanes b) {
  return alternate<1>(a, b, Sequence<lanes>{});
}

// a_0 b_0 a_1 b_1 ... of one half each.
template <int half, int... i>
[[gnu::always_inline]] inline Lanes zip(Lanes a, Lanes b, Indices<i...> /*of lanes*/) {
  return __builtin_shufflevector(a, b, (half * lanes / 2 + i / 2 + i % 2 * lanes)...);
}
// Every other number of a, then of b.
template <int offset, int... i>
[[gnu::always_inline]] inline Lanes unzip(Lanes a, Lanes b, Indices<i...> /*of lanes*/) {
  return __builtin_shufflevector(a, b, (2 * i + offset)...);
}

// Every other row of a matrix of as many rows as lanes, from the pairs of numbers that they have in
// pairs of columns.
[[gnu::always_inline]] inline void join_pairs(const Vector2* pairs, Vector2* row) {
  row[0] = pairs[0];
}
[[gnu::always_inline]] inline void join_pairs(const Vector4* pairs, Vector4* row) {
  row[0] = __builtin_shufflevector(pairs[0], pairs[1], 0, 1, 4, 5);
  row[2] = __builtin_shufflevector(pairs[0], pairs[1], 2, 3, 6, 7);
}
[[gnu::always_inline]] inline void join_pairs(const Vector8* pairs, Vector8* row) {
  for (int half = 0; half < 2; ++half) {
    const auto join = [half](Vector8 a, Vector8 b) {
      return half == 0 ? __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11)
                       : __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
    };
    const Vector8 a = join(pairs[0], pairs[1]), b = join(pairs[2], pairs[3]);
    row[4 * half] = __builtin_shufflevector(a, b, 0, 1, 4, 5, 8, 9, 12, 13);
    row[4 * half + 2] = __builtin_shufflevector(a, b, 2, 3, 6, 7, 10, 11, 14, 15);
  }
}

// The number in lane j of m[i] and that in lane i of m[j] change places.
[[gnu::always_inline]] inline void transpose(Lanes* m) {
  Lanes p[lanes / 2], q[lanes / 2];  // of even and of odd rows
  for (int k = 0; k < lanes / 2; ++k) {
    p[k] = even(m[2 * k], m[2 * k + 1]);
    q[k] = odd(m[2 * k], m[2 * k + 1]);
  }
  join_pairs(p, m);
  join_pairs(q, m + 1);
}

// The numbers at x[0], x[2], ..., two of each.
template <class Vector>
[[gnu::always_inline]] inline Vector load_pairs(const double* const* x) {
  if constexpr (sizeof(Vector) == sizeof(Vector2)) {
    return load<Vector2>(x[0]);
  } else if constexpr (sizeof(Vector) == sizeof(Vector4)) {
    return __builtin_shufflevector(load_pairs<Vector2>(x), load_pairs<Vector2>(x + 2), 0, 1, 2, 3);
  } else {
    return __builtin_shufflevector(load_pairs<Vector4>(x), load_pairs<Vector4>(x + 4), 0, 1, 2, 3,
                                   4, 5, 6, 7);
  }
}

template <int... i>
[[gnu::always_inline]] inline Lanes load_single(const double* const* x, Indices<i...> /*of lanes*/,
                                                int at) {
  return Lanes{x[i][at]...};
}

// column[k] gets the number x[lane][k] in each lane, for k < N.
template <int N, int from = 0>
[[gnu::always_inline]] inline void load_columns(const double* const* x, Lanes* column) {
  if constexpr (N - from >= lanes) {
    for (int i = 0; i < lanes; ++i) column[from + i] = load<Lanes>(x[i] + from);
    transpose(column + from);
    load_columns<N, from + lanes>(x, column);
  } else if constexpr (N - from >= 2) {
    const double* shifted[lanes];
    for (int i = 0; i < lanes; ++i) shifted[i] = x[i] + from;
    const Lanes p = load_pairs<Lanes>(shifted), q = load_pairs<Lanes>(shifted + 1);
    column[from] = even(p, q);
    column[from + 1] = odd(p, q);
    load_columns<N, from + 2>(x, column);
  } else if constexpr (N - from == 1) {
    column[from] = load_single(x, Sequence<lanes>{}, from);
  }
}

// The same where lane after lane has its N numbers in memory.
template <int N>
[[gnu::always_inline]] inline void load_rows(const double* x, Lanes* column) {
  if constexpr (N == 2) {
    const auto a = load<Lanes>(x), b = load<Lanes>(x + lanes);
    column[0] = unzip<0>(a, b, Sequence<lanes>{});
    column[1] = unzip<1>(a, b, Sequence<lanes>{});
  } else {
    const double* at[lanes];
    for (int i = 0; i < lanes; ++i) at[i] = x + N * i;
    load_columns<N>(at, column);
  }
}

// Two numbers of each lane: those of the even lanes in p, of the odd ones in q.
template <int stride, int... i>
[[gnu::always_inline]] inline void store_pairs(Lanes p, Lanes q, double* x,
                                               Indices<i...> /*of half the lanes*/) {
  (store(__builtin_shufflevector(p, p, 2 * i, 2 * i + 1), x + 2 * i * stride), ...);
  (store(__builtin_shufflevector(q, q, 2 * i, 2 * i + 1), x + (2 * i + 1) * stride), ...);
}

// Four numbers of each of the even or odd ones of 8 lanes, from its pairs in two pairs of columns.
template <int stride>
[[gnu::always_inline]] inline void store_fours(Vector8 a, Vector8 b, double* x) {
  const Vector8 first = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
  const Vector8 second = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
  store(__builtin_shufflevector(first, first, 0, 1, 2, 3), x);
  store(__builtin_shufflevector(second, second, 0, 1, 2, 3), x + 2 * stride);
  store(__builtin_shufflevector(first, first, 4, 5, 6, 7), x + 4 * stride);
  store(__builtin_shufflevector(second, second, 4, 5, 6, 7), x + 6 * stride);
}

// x[lane * stride + k] = column[k] of that lane, for k < N.
template <int N, int stride = N>
[[gnu::always_inline]] inline void store_rows(const Lanes* column, double* x) {
  if constexpr (N == 2 && stride == 2) {
    store(zip<0>(column[0], column[1], Sequence<lanes>{}), x);
    store(zip<1>(column[0], column[1], Sequence<lanes>{}), x + lanes);
  } else if constexpr (N >= lanes) {
    Lanes row[lanes];
    for (int i = 0; i < lanes; ++i) row[i] = column[i];
    transpose(row);
    for (int i = 0; i < lanes; ++i) store(row[i], x + i * stride);
    store_rows<N - lanes, stride>(column + lanes, x + lanes);
  } else if constexpr (N >= 4) {
    store_fours<stride>(even(column[0], column[1]), even(column[2], column[3]), x);
    store_fours<stride>(odd(column[0], column[1]), odd(column[2], column[3]), x + stride);
    store_rows<N - 4, stride>(column + 4, x + 4);
  } else if constexpr (N >= 2) {
    store_pairs<stride>(even(column[0], column[1]), odd(column[0], column[1]), x,
                        Sequence<lanes / 2>{});
    store_rows<N - 2, stride>(column + 2, x + 2);
  } else if constexpr (N == 1) {
    for (int i = 0; i < lanes; ++i) x[i * stride] = column[0][i];
  }
}

// The numbers of lanes `first` and later; 0 in those before.
template <int... i>
[[gnu::always_inline]] inline Lanes from_lane(std::int64_t first, Lanes v, Indices<i...>) {
  return LaneIndices{i...} >= first ? v : Lanes{};
}
[[gnu::always_inline]] inline Lanes from_lane(std::int64_t first, Lanes v) {
  return from_lane(first, v, Sequence<lanes>{});
}

[[gnu::always_inline]] inline double sum(Lanes v) {
  double total = v[0];
  for (int i = 1; i < lanes; ++i) total += v[i];
  return total;
}

[[gnu::always_inline]] inline double root(double x) { return __builtin_sqrt(x); }
[[gnu::always_inline]] inline Lanes root(Lanes v) {
  double x[lanes];
  store(v, x);
  for (double& each : x) each = __builtin_sqrt(each);
  return load<Lanes>(x);
}

}  // namespace
}  // namespace raybundle::RAYBUNDLE_ISA
