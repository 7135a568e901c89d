// A row of N numbers in registers, as a vector and what is left over: the compilers we use do not
// vectorise loops of 9 or 6 well by themselves. Included by the kernel units only; the vectors are
// lowered to whatever the unit is compiled for.

#pragma once

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
  double sum() const { return RAYBUNDLE_ISA::sum(head) + tail.sum(); }
  double operator[](int i) const { return i < width ? head[i] : tail[i - width]; }
};

template <int N>
[[gnu::always_inline]] inline double dot(const Row<N>& x, const Row<N>& y) {
  Row<N> products = {};
  products.add_products(x, y);
  return products.sum();
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
}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
