// The block of J of one row by one of its unknown blocks: R residuals by N unknowns, of numbers T,
// stored as in_pairs() says. Included by the kernel units only.

#pragma once

#include <raybundle/linalg/kernels/kernel_table.h>
#include <raybundle/linalg/kernels/row.h>

namespace raybundle::linalg::RAYBUNDLE_ISA {
namespace {

template <class T, int R, int N>
struct StoredBlock {
  static constexpr int size = R * N;
  static constexpr int operand = operand_size(R, N);
  T* values;

  static T* of_row(const void* J, std::int64_t row) {
    return const_cast<T*>(static_cast<const T*>(J)) + row * size;
  }
};

template <class T, int R, int N, bool pairs = in_pairs(R)>
struct RowBlock;

// Residual by residual.
template <class T, int R, int N>
struct RowBlock<T, R, N, false> : StoredBlock<T, R, N> {
  using Operand = Row<N>;  // of products that are done with many rows
  static RowBlock of(const void* J, std::int64_t row) {
    return {StoredBlock<T, R, N>::of_row(J, row)};
  }
  static Operand spread(const Row<N>& x) { return x; }
  static Operand spread(const double* x) { return Row<N>::load(x); }

  Row<N> residual(int r) const { return Row<N>::load(this->values + r * N); }
  void residuals(Row<N>* rows) const {
    for (int r = 0; r < R; ++r) rows[r] = residual(r);
  }
  /// J x
  Row<R> times(const Operand& x) const { return product<R, N>(this->values, x); }
  /// y += J^T u
  void add_transposed(const Row<R>& u, Operand& y) const {
    for (int r = 0; r < R; ++r) y.add(u[r], residual(r));
  }
  static Row<N> collect(const Operand& y) { return y; }
  static void collect(const Operand& y, double* sum) { y.store(sum); }
  /// Rounds a block that is given residual by residual.
  void store(const Row<N>* rows) const {
    for (int r = 0; r < R; ++r) rows[r].store(this->values + r * N);
  }
};

// Unknown by unknown: pairs of residuals fill vectors of any width, and products need no sums
// across a vector but a last one.
template <class T, int N>
struct RowBlock<T, 2, N, true> : StoredBlock<T, 2, N> {
  using Operand = Row<2 * N>;
  static RowBlock of(const void* J, std::int64_t row) {
    return {StoredBlock<T, 2, N>::of_row(J, row)};
  }
  static Operand spread(const Row<N>& x) { return interleave(x, x); }
  static Operand spread(const double* x) {
    if constexpr (N == 3) {  // three numbers that were computed one by one
      return {Vector4{x[0], x[0], x[1], x[1]}, {Vector2{x[2], x[2]}, {}}};
    } else {
      return spread(Row<N>::load(x));
    }
  }

  Operand all() const { return Operand::load(this->values); }
  void residuals(Row<N>* rows) const {
    rows[0] = deinterleave<0>(all());
    rows[1] = deinterleave<1>(all());
  }
  Row<2> times(const Operand& x) const {
    const Operand J = all();
    return {pair_dot(J.tail, x.tail, J.head * x.head), {}};
  }
  void add_transposed(const Row<2>& u, Operand& y) const { y.add_repeated(all(), u.head); }
  static Row<N> collect(const Operand& y) {
    Row<N> sum = deinterleave<0>(y);
    sum.add(1, deinterleave<1>(y));
    return sum;
  }
  static void collect(const Operand& y, double* sum) {
    if constexpr (N == 3) {
      sum[0] = y.head[0] + y.head[1];
      sum[1] = y.head[2] + y.head[3];
      sum[2] = y.tail.head[0] + y.tail.head[1];
    } else {
      collect(y).store(sum);
    }
  }
  void store(const Row<N>* rows) const { interleave(rows[0], rows[1]).store(this->values); }
};

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
