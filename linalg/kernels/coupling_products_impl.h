// What the rows of eliminated blocks add to the reduced matrix, coupling by coupling; see
// kernel_table.h for U, y and W. K unknowns per kept block, E per eliminated block.

#pragma once

#include <raybundle/linalg/kernels/block_kernels_impl.h>

namespace raybundle::linalg::RAYBUNDLE_ISA {
namespace {

// Where products are added: a block with a stride between its rows.
template <int K>
struct Square {
  double* values;
  Index stride;

  /// += left^T right, of N rows each.
  template <int N>
  [[gnu::always_inline]] void add(const double* left, const Row<K>* right) const {
#pragma GCC unroll 12
    for (int i = 0; i < K; ++i) {
      auto sum = Row<K>::load(values + i * stride);
      for (int k = 0; k < N; ++k) sum.add(left[k * K + i], right[k]);
      sum.store(values + i * stride);
    }
  }
};

// The same, of a symmetric block; see triangle_width().
template <int K>
struct Triangle {
  double* values;

  template <int N, int i = 0>
  [[gnu::always_inline]] void add(const double* left, const Row<K>* right) const {
    constexpr int W = triangle_width(K, i);
    double* row = values + triangle_begin(K, i);
    auto sum = Row<W>::load(row);
    for (int k = 0; k < N; ++k) sum.add(left[k * K + i], first_of<W>(right[k]));
    sum.store(row);
    if constexpr (i + 1 < K) add<N, i + 1>(left, right);
  }
};

// What two couplings of an eliminated block, or twice the same, add to the reduced matrix.
template <int R, int K, int E, bool anchored>
struct CouplingProducts;

// From the rows themselves: cheaper than W while R < E, and a coupling has few rows, mostly one.
template <int R, int K, int E>
struct CouplingProducts<R, K, E, false> {
  [[gnu::always_inline]] static void form(const EliminationView& /*view*/, Index /*e*/) {}

  [[gnu::always_inline]] static void prefetch_coupling(const EliminationView& view, Index c) {
    prefetch<2 * R * K * 8>(view.J_kept + row_begin(view.kept, c) * R * K);
    prefetch<2 * R * E * 8>(view.U + row_begin(view.kept, c) * R * E);
  }

  // v -= J^T U y.
  [[gnu::always_inline]] static void reduce(const EliminationView& view, Index e, Index c,
                                            Row<K>& v) {
    for_rows_of(view.kept, c, [&](Index row) {
      Row<R> Uy = {};
      for (int i = 0; i < E; ++i) {
        Uy.add(view.y[e * E + i], Row<R>::load(view.U + (row * E + i) * R));
      }
      for (int k = 0; k < R; ++k) v.add(-Uy[k], Row<K>::load(view.J_kept + (row * R + k) * K));
    });
  }

  // A += J_a^T (I - U U^T)_ab J_b for one row of a and one of b, both of one coupling or not.
  template <bool same, class Target>
  [[gnu::always_inline]] static void add_rows(const EliminationView& view, Index row_a, Index row_b,
                                              const Target& A) {
    const double* U_a = view.U + row_a * E * R;
    const double* U_b = view.U + row_b * E * R;
    Row<R> UU[R] = {};  // U_a U_b^T
    for (int i = 0; i < E; ++i) {
      const auto U_bi = Row<R>::load(U_b + i * R);
      for (int r = 0; r < R; ++r) UU[r].add(U_a[i * R + r], U_bi);
    }
    Row<K> right[R] = {};
    for (int r = 0; r < R; ++r) {
      if (same && row_a == row_b) right[r] = Row<K>::load(view.J_kept + (row_a * R + r) * K);
      for (int s = 0; s < R; ++s) {
        right[r].add(-UU[r][s], Row<K>::load(view.J_kept + (row_b * R + s) * K));
      }
    }
    A.template add<R>(view.J_kept + row_a * R * K, right);
  }

  template <bool same, class Target>
  [[gnu::always_inline]] static void add(const EliminationView& view, Index /*e*/, Index c,
                                         Index other, const Target& A) {
    for_rows_of(view.kept, c, [&](Index row) {
      for_rows_of(view.kept, other, [&](Index next) { add_rows<same>(view, row, next, A); });
    });
  }
};

// By W, into which the damping of anchored leaves goes.
template <int R, int K, int E>
struct CouplingProducts<R, K, E, true> {
  // W^T = M^T (J_e^T J_k - D Z)
  [[gnu::always_inline]] static void form(const EliminationView& view, Index e) {
    const double* M = view.M + e * E * E;
    const double* D = view.D + e * E;
    for (Index c = view.eliminated.begin[e]; c < view.eliminated.begin[e + 1]; ++c) {
      Row<K> W[E] = {};
      for_rows_of(view.kept, c, [&](Index row) {
        for (int k = 0; k < R; ++k) {
          const auto x = Row<K>::load(view.J_kept + (row * R + k) * K);
          for (int i = 0; i < E; ++i) W[i].add(view.U[(row * E + i) * R + k], x);
        }
      });
      const Index anchor = view.anchors.of_coupling[c];
      for (int k = 0; anchor >= 0 && k < E; ++k) {
        const auto Z = Row<K>::load(view.anchors.Z + (anchor * E + k) * K);
        for (int i = 0; i < E; ++i) W[i].add(-M[k * E + i] * D[k], Z);
      }
      for (int i = 0; i < E; ++i) W[i].store(view.W + (c * E + i) * K);
    }
  }

  [[gnu::always_inline]] static void prefetch_coupling(const EliminationView& view, Index c) {
    prefetch<E * K * 8>(view.W + c * E * K);
    const Index anchor = view.anchors.of_coupling[c];
    if (anchor >= 0) prefetch<E * K * 8>(view.anchors.Z + anchor * E * K);
  }

  // v -= W y.
  [[gnu::always_inline]] static void reduce(const EliminationView& view, Index e, Index c,
                                            Row<K>& v) {
    for (int i = 0; i < E; ++i) {
      v.add(-view.y[e * E + i], Row<K>::load(view.W + (c * E + i) * K));
    }
  }

  // A += Z_a^T D Z_b - W_a W_b^T, and J_a^T J_a where the two are the same.
  template <bool same, class Target>
  [[gnu::always_inline]] static void add(const EliminationView& view, Index e, Index c, Index other,
                                         const Target& A) {
    if constexpr (same) {
      for_rows_of(view.kept, c, [&](Index row) {
        const double* J = view.J_kept + row * R * K;
        Row<K> right[R];
        for (int r = 0; r < R; ++r) right[r] = Row<K>::load(J + r * K);
        A.template add<R>(J, right);
      });
    }
    Row<K> right[E] = {};
    for (int k = 0; k < E; ++k) right[k].add(-1, Row<K>::load(view.W + (other * E + k) * K));
    A.template add<E>(view.W + c * E * K, right);
    const Index a = view.anchors.of_coupling[c], b = view.anchors.of_coupling[other];
    if (a < 0 || b < 0) return;
    for (int k = 0; k < E; ++k) {
      right[k] = {};
      right[k].add(view.D[e * E + k], Row<K>::load(view.anchors.Z + (b * E + k) * K));
    }
    A.template add<E>(view.anchors.Z + a * E * K, right);
  }
};

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
