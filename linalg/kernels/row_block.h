// The block of J of one row by one of its unknown blocks: R residuals by N unknowns, of numbers T.
// Wide blocks are stored residual by residual, narrow ones unknown by unknown: a vector of the
// processor then has something to do either way. Included by the kernel units only.

#pragma once

#include <raybundle/linalg/kernels/kernel_table.h>
#include <raybundle/linalg/kernels/row.h>

namespace raybundle::linalg::RAYBUNDLE_ISA {
namespace {

template <class T, int R, int N, bool narrow = is_narrow(N)>
struct RowBlock;

template <class T, int R, int N>
struct RowBlock<T, R, N, false> {
  static constexpr int size = R * N;
  T* values;

  static RowBlock of(const void* J, std::int64_t row) {
    return {const_cast<T*>(static_cast<const T*>(J)) + row * size};
  }
  /// The derivatives of residual r.
  Row<N> residual(int r) const { return Row<N>::load(values + r * N); }
  /// J x
  Row<R> times(const Row<N>& x) const { return product<R, N>(values, x); }

  /// J^T u over rows.
  struct Sums {
    Row<N> sum = {};
    void add(const RowBlock& J, const Row<R>& u) {
      for (int r = 0; r < R; ++r) sum.add(u[r], J.residual(r));
    }
    Row<N> total() const { return sum; }
  };
  void add_transposed(const Row<R>& u, Row<N>& y) const {
    for (int r = 0; r < R; ++r) y.add(u[r], residual(r));
  }
  /// Rounds a block that is given residual by residual.
  void store(const double* exact) const {
    for (int r = 0; r < R; ++r) Row<N>::load(exact + r * N).store(values + r * N);
  }
};

template <class T, int R, int N>
struct RowBlock<T, R, N, true> {
  static constexpr int size = R * N;
  T* values;

  static RowBlock of(const void* J, std::int64_t row) {
    return {const_cast<T*>(static_cast<const T*>(J)) + row * size};
  }
  Row<N> residual(int r) const {
    double x[N];
    for (int i = 0; i < N; ++i) x[i] = values[i * R + r];
    return Row<N>::load(x);
  }
  Row<R> unknown(int i) const { return Row<R>::load(values + i * R); }
  Row<R> times(const Row<N>& x) const {
    Row<R> u = {};
    for (int i = 0; i < N; ++i) u.add(x[i], unknown(i));
    return u;
  }

  struct Sums {
    Row<R> part[N] = {};
    void add(const RowBlock& J, const Row<R>& u) {
      for (int i = 0; i < N; ++i) part[i].add_products(J.unknown(i), u);
    }
    Row<N> total() const {
      double x[N];
      for (int i = 0; i < N; ++i) x[i] = part[i].sum();
      return Row<N>::load(x);
    }
  };
  void add_transposed(const Row<R>& u, Row<N>& y) const {
    Sums sums;
    sums.add(*this, u);
    y.add(1, sums.total());
  }
  void store(const double* exact) const {
    for (int i = 0; i < N; ++i) {
      for (int r = 0; r < R; ++r) values[i * R + r] = static_cast<T>(exact[r * N + i]);
    }
  }
};

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
