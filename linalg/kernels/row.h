// A row of N numbers in registers, as a vector and what is left over: the compilers we use do not
// vectorise loops of 9 or 6 well by themselves. Included by the kernel units only; the vectors are
// lowered to whatever the unit is compiled for.

#pragma once

#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace raybundle::linalg::RAYBUNDLE_ISA {
namespace {

using Vector2 [[gnu::vector_size(16)]] = double;
using Vector4 [[gnu::vector_size(32)]] = double;
using Vector8 [[gnu::vector_size(64)]] = double;

// Vectors of double, from numbers of either precision and back.
template <class Vector>
inline Vector load_vector(const double* x) {
  Vector v;
  __builtin_memcpy(&v, x, sizeof(v));
  return v;
}
template <class Vector>
inline Vector load_vector(const float* x) {
  using Singles [[gnu::vector_size(sizeof(Vector) / 2)]] = float;
  Singles v;
  __builtin_memcpy(&v, x, sizeof(v));
  return __builtin_convertvector(v, Vector);
}
// GCC 12 converts in pieces of two and four where one instruction would do.
#ifdef __SSE2__
template <>
inline Vector2 load_vector<Vector2>(const float* x) {
  double both;  // two numbers, wherever they stand
  __builtin_memcpy(&both, x, sizeof(both));
  return _mm_cvtps_pd(_mm_castpd_ps(_mm_set_sd(both)));
}
#endif
#ifdef __AVX__
template <>
inline Vector4 load_vector<Vector4>(const float* x) {
  return _mm256_cvtps_pd(_mm_loadu_ps(x));
}
#endif
#ifdef __AVX512F__
template <>
inline Vector8 load_vector<Vector8>(const float* x) {
  return _mm512_maskz_cvtps_pd(0xff, _mm256_loadu_ps(x));
}
#endif
template <class Vector>
inline void store_vector(Vector v, double* x) {
  __builtin_memcpy(x, &v, sizeof(v));
}
template <class Vector>
inline void store_vector(Vector v, float* x) {
  using Singles [[gnu::vector_size(sizeof(Vector) / 2)]] = float;
  const Singles rounded = __builtin_convertvector(v, Singles);
  __builtin_memcpy(x, &rounded, sizeof(rounded));
}

inline Vector2 fold(Vector4 v) {
  return __builtin_shufflevector(v, v, 0, 1) + __builtin_shufflevector(v, v, 2, 3);
}
inline Vector4 fold(Vector8 v) {
  return __builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7);
}

// u in all pairs of lanes.
template <class Vector>
inline Vector repeat(Vector2 u) {
  if constexpr (sizeof(Vector) == sizeof(Vector8)) {
#ifdef __AVX512DQ__
    return _mm512_maskz_broadcast_f64x2(0xff, u);  // GCC 12 goes through memory otherwise
#else
    return __builtin_shufflevector(u, u, 0, 1, 0, 1, 0, 1, 0, 1);
#endif
  } else if constexpr (sizeof(Vector) == sizeof(Vector4)) {
    return __builtin_shufflevector(u, u, 0, 1, 0, 1);
  } else {
    return u;
  }
}
// The sum over all pairs of lanes.
inline Vector2 sum_pairs(Vector2 v) { return v; }
inline Vector2 sum_pairs(Vector4 v) { return fold(v); }
inline Vector2 sum_pairs(Vector8 v) { return fold(fold(v)); }

inline double sum(Vector2 v) { return v[0] + v[1]; }
inline double sum(Vector4 v) { return sum(fold(v)); }
inline double sum(Vector8 v) { return sum(fold(v)); }

// The sums of two vectors at once.
inline Vector2 sums(Vector2 a, Vector2 b) {
  return __builtin_shufflevector(a, b, 0, 2) + __builtin_shufflevector(a, b, 1, 3);
}
inline Vector2 sums(Vector4 a, Vector4 b) {
  return fold(__builtin_shufflevector(a, b, 0, 4, 2, 6) +
              __builtin_shufflevector(a, b, 1, 5, 3, 7));
}
inline Vector2 sums(Vector8 a, Vector8 b) { return sums(fold(a), fold(b)); }

template <int N>
struct Row;

template <>
struct Row<0> {
  template <class T>
  static Row load(const T* /*x*/) {
    return {};
  }
  template <class T>
  void store(T* /*x*/) const {}
  void add(double /*a*/, const Row& /*x*/) {}
  void add_products(const Row& /*x*/, const Row& /*y*/) {}
  void add_repeated(const Row& /*x*/, Vector2 /*u*/) {}
  double sum() const { return 0; }
  double operator[](int /*i*/) const { return 0; }
};

template <>
struct Row<1> {
  double value = 0;
  template <class T>
  static Row load(const T* x) {
    return {*x};
  }
  template <class T>
  void store(T* x) const {
    *x = static_cast<T>(value);
  }
  void add(double a, const Row& x) { value += a * x.value; }
  void add_products(const Row& x, const Row& y) { value += x.value * y.value; }
  double sum() const { return value; }
  double operator[](int /*i*/) const { return value; }
};

// The widest vector that fits.
template <int N>
auto widest() {
  if constexpr (N >= 8) {
    return Vector8{};
  } else if constexpr (N >= 4) {
    return Vector4{};
  } else {
    return Vector2{};
  }
}

template <int N>
struct Row {
  using Head = decltype(widest<N>());
  static constexpr int width = sizeof(Head) / sizeof(double);
  using Tail = Row<N - width>;

  Head head = {};
  Tail tail = {};

  template <class T>
  static Row load(const T* x) {
    return {load_vector<Head>(x), Tail::load(x + width)};
  }
  template <class T>
  void store(T* x) const {
    store_vector(head, x);
    tail.store(x + width);
  }
  /// this += a x
  void add(double a, const Row& x) {
    head += a * x.head;
    tail.add(a, x.tail);
  }
  /// this_i += x_i y_i
  void add_products(const Row& x, const Row& y) {
    head += x.head * y.head;
    tail.add_products(x.tail, y.tail);
  }
  /// The same of pairs of numbers, with u_0 and u_1 in turn for y.
  void add_repeated(const Row& x, Vector2 u) {
    head += x.head * repeat<Head>(u);
    tail.add_repeated(x.tail, u);
  }
  double sum() const { return RAYBUNDLE_ISA::sum(head) + tail.sum(); }
  double operator[](int i) const { return i < width ? head[i] : tail[i - width]; }
};

template <int N>
[[gnu::always_inline]] inline double dot(const Row<N>& x, const Row<N>& y) {
  Row<N> products = {};
  products.add_products(x, y);
  return products.sum();
}

// The sum of a_i b_i over all pairs of numbers, starting with `sum`.
template <int N, class Vector>
[[gnu::always_inline]] inline Vector2 pair_dot(const Row<N>& a, const Row<N>& b, Vector sum) {
  if constexpr (N == 0) {
    return sum_pairs(sum);
  } else if constexpr (sizeof(a.head) == sizeof(Vector)) {
    return pair_dot(a.tail, b.tail, sum + a.head * b.head);
  } else {
    return pair_dot(a, b, fold(sum));
  }
}

// The first W of N numbers, which make a vector or are all.
template <int W, int N>
[[gnu::always_inline]] inline Row<W> first_of(const Row<N>& x) {
  if constexpr (W == N) {
    return x;
  } else if constexpr (W == Row<N>::width) {
    return {x.head};
  } else {
    static_assert(W == 4 && Row<N>::width == 8);
    return {__builtin_shufflevector(x.head, x.head, 0, 1, 2, 3)};
  }
}

// The two products with y of a matrix of two rows; N numbers of them each, from the first on.
template <int N, class T>
[[gnu::always_inline]] inline Vector2 two_dots(const T* first, const T* second, const Row<N>& y) {
  if constexpr (N == 0) {
    return Vector2{};
  } else if constexpr (N == 1) {
    return Vector2{double{*first}, double{*second}} * y.value;
  } else {
    using Head = typename Row<N>::Head;
    constexpr int width = Row<N>::width;
    return sums(load_vector<Head>(first) * y.head, load_vector<Head>(second) * y.head) +
           two_dots<N - width>(first + width, second + width, y.tail);
  }
}

// A x, with A of R x N, row-major.
template <int R, int N, class T>
[[gnu::always_inline]] inline Row<R> product(const T* A, const Row<N>& x) {
  if constexpr (R == 0) {
    return {};
  } else if constexpr (R == 1) {
    return {dot(Row<N>::load(A), x)};
  } else {
    return {two_dots<N>(A, A + N, x), product<R - 2, N>(A + 2 * N, x)};
  }
}

// From two rows of N to N pairs and back: a_0 b_0 a_1 b_1 ...
template <int N>
[[gnu::always_inline]] inline Row<2 * N> interleave(const Row<N>& a, const Row<N>& b) {
  if constexpr (N == 1) {
    return {Vector2{a.value, b.value}, {}};
  } else if constexpr (N == 2) {
    return {__builtin_shufflevector(a.head, b.head, 0, 2, 1, 3), {}};
  } else if constexpr (N == 3) {
    return {interleave<2>({a.head, {}}, {b.head, {}}).head, interleave(a.tail, b.tail)};
  } else if constexpr (N == 6) {
    return {__builtin_shufflevector(a.head, b.head, 0, 4, 1, 5, 2, 6, 3, 7),
            interleave(a.tail, b.tail)};
  } else {
    static_assert(N == 9);
    return {__builtin_shufflevector(a.head, b.head, 0, 8, 1, 9, 2, 10, 3, 11),
            {__builtin_shufflevector(a.head, b.head, 4, 12, 5, 13, 6, 14, 7, 15),
             interleave(a.tail, b.tail)}};
  }
}

// Of N pairs the first (at = 0) or the second numbers (1).
template <int at, int N>
[[gnu::always_inline]] inline Row<N / 2> deinterleave(const Row<N>& x) {
  if constexpr (N == 2) {
    return {x.head[at]};
  } else if constexpr (N == 4) {
    return {__builtin_shufflevector(x.head, x.head, at, at + 2), {}};
  } else if constexpr (N == 6) {
    return {deinterleave<at, 4>({x.head, {}}).head, deinterleave<at>(x.tail)};
  } else if constexpr (N == 12) {
    return {__builtin_shufflevector(x.head, x.head, at, at + 2, at + 4, at + 6),
            deinterleave<at>(x.tail)};
  } else {
    static_assert(N == 18);
    return {__builtin_shufflevector(x.head, x.tail.head, at, at + 2, at + 4, at + 6, at + 8,
                                    at + 10, at + 12, at + 14),
            deinterleave<at>(x.tail.tail)};
  }
}

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
