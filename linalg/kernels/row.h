// A row of N numbers in registers, as a vector and what is left over: the compilers we use do not
// vectorise loops of 9 or 6 well by themselves. Included by the kernel units only; the vectors are
// lowered to whatever the unit is compiled for.

#pragma once

namespace raybundle::linalg::RAYBUNDLE_ISA {
namespace {

using Vector2 [[gnu::vector_size(16)]] = double;
using Vector4 [[gnu::vector_size(32)]] = double;
using Vector8 [[gnu::vector_size(64)]] = double;

template <class Vector>
inline Vector load_vector(const double* x) {
  Vector v;
  __builtin_memcpy(&v, x, sizeof(v));
  return v;
}

inline double sum(Vector2 v) { return v[0] + v[1]; }
inline double sum(Vector4 v) { return sum(Vector2{v[0], v[1]} + Vector2{v[2], v[3]}); }
inline double sum(Vector8 v) {
  return sum(Vector4{v[0], v[1], v[2], v[3]} + Vector4{v[4], v[5], v[6], v[7]});
}

template <int N>
struct Row;

template <>
struct Row<0> {
  static Row load(const double* /*x*/) { return {}; }
  void store(double* /*x*/) const {}
  void add(double /*a*/, const Row& /*x*/) {}
  void add_products(const Row& /*x*/, const Row& /*y*/) {}
  static double dot(const double* /*x*/, const double* /*y*/) { return 0; }
};

template <>
struct Row<1> {
  double value = 0;
  static Row load(const double* x) { return {*x}; }
  void store(double* x) const { *x = value; }
  void add(double a, const Row& x) { value += a * x.value; }
  void add_products(const Row& x, const Row& y) { value += x.value * y.value; }
  static double dot(const double* x, const double* y) { return *x * *y; }
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

  static Row load(const double* x) { return {load_vector<Head>(x), Tail::load(x + width)}; }
  void store(double* x) const {
    __builtin_memcpy(x, &head, sizeof(head));
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
  static double dot(const double* x, const double* y) {
    return sum(load_vector<Head>(x) * load_vector<Head>(y)) + Tail::dot(x + width, y + width);
  }
};

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
