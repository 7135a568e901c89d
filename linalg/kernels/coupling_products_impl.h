// What the rows of eliminated blocks add to the reduced matrix, coupling by coupling; see
// kernel_table.h for M, q and W. K unknowns per kept block, E per eliminated block.

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

// t = M^T w and s = M t of one eliminated block. Plain loops: for three numbers vectors do not pay.
template <int E>
[[gnu::always_inline]] inline void times_factor_transposed(const double* M, const double* w,
                                                           double* t) {
  for (int i = 0; i < E; ++i) {
    t[i] = 0;
    for (int k = 0; k < E; ++k) t[i] += M[k * E + i] * w[k];
  }
}
template <int E>
[[gnu::always_inline]] inline void solve_factored(const double* M, const double* w, double* s) {
  double t[E];
  times_factor_transposed<E>(M, w, t);
  for (int i = 0; i < E; ++i) {
    s[i] = 0;
    for (int k = 0; k < E; ++k) s[i] += M[i * E + k] * t[k];
  }
}

// What two couplings of an eliminated block, or twice the same, add to the reduced matrix: from the
// left one, prepared once for all right ones.
template <class T, int R, int K, int E, bool anchored>
struct CouplingProducts;

// From the rows themselves: cheaper than W while R < E, and a coupling has few rows, mostly one.
template <class T, int R, int K, int E>
struct CouplingProducts<T, R, K, E, false> {
  using OfKept = RowBlock<T, R, K>;
  using OfEliminated = RowBlock<T, R, E>;

  [[gnu::always_inline]] static void prefetch_coupling(const EliminationView& view, Index c) {
    constexpr int number = sizeof(T);
    prefetch<R * K * number>(OfKept::of(view.J_kept, row_begin(view.kept, c)).values);
    prefetch<R * E * number>(OfEliminated::of(view.J_eliminated, row_begin(view.kept, c)).values);
  }

  // v -= J_k^T J_e q.
  [[gnu::always_inline]] static void reduce(const EliminationView& view, Index e, Index c,
                                            Row<K>& v) {
    const auto q = OfEliminated::spread(view.q + e * E);
    typename OfKept::Operand sum = {};
    for_rows_of(view.kept, c, [&](Index row) {
      const Row<R> u = OfEliminated::of(view.J_eliminated, row).times(q);
      OfKept::of(view.J_kept, row).add_transposed(u, sum);
    });
    v.add(-1, OfKept::collect(sum));
  }

  // One row of the left coupling: J_k, and N J_e^T with N = M M^T, by residual.
  struct Left {
    Index row;
    double J[R * K];
    typename OfEliminated::Operand NJ[R];
  };
  template <class Visit>
  [[gnu::always_inline]] static void for_lefts(const EliminationView& view, Index e, Index c,
                                               Visit&& visit) {
    const double* M = view.M + e * E * E;
    for_rows_of(view.kept, c, [&](Index row) {
      Left left;
      left.row = row;
      Row<K> kept[R];
      Row<E> eliminated[R];
      OfKept::of(view.J_kept, row).residuals(kept);
      OfEliminated::of(view.J_eliminated, row).residuals(eliminated);
      for (int r = 0; r < R; ++r) {
        kept[r].store(left.J + r * K);
        double J_e[E], NJ[E];
        eliminated[r].store(J_e);
        solve_factored<E>(M, J_e, NJ);
        left.NJ[r] = OfEliminated::spread(NJ);
      }
      visit(left);
    });
  }

  // A += J_a^T (I - J_e N J_e^T)_ab J_b.
  template <bool same, class Target>
  [[gnu::always_inline]] static void add(const EliminationView& view, Index /*e*/, const Left& left,
                                         Index other, const Target& A) {
    for_rows_of(view.kept, other, [&](Index row) {
      Row<K> kept[R], right[R] = {};
      OfKept::of(view.J_kept, row).residuals(kept);
      const OfEliminated eliminated = OfEliminated::of(view.J_eliminated, row);
      for (int r = 0; r < R; ++r) {
        if (same && row == left.row) right[r] = kept[r];
        const Row<R> JNJ = eliminated.times(left.NJ[r]);
        for (int s = 0; s < R; ++s) right[r].add(-JNJ[s], kept[s]);
      }
      A.template add<R>(left.J, right);
    });
  }
};

// By W, into which the damping of anchored leaves goes.
template <class T, int R, int K, int E>
struct CouplingProducts<T, R, K, E, true> {
  using OfKept = RowBlock<T, R, K>;
  using OfEliminated = RowBlock<T, R, E>;

  // W^T = M^T (J_e^T J_k - D Z)
  [[gnu::always_inline]] static void form(const EliminationView& view, Index e, Index c,
                                          double* W) {
    const double* M = view.M + e * E * E;
    const double* D = view.D + e * E;
    Row<K> sums[E] = {};
    for_rows_of(view.kept, c, [&](Index row) {
      Row<K> kept[R];
      Row<E> eliminated[R];
      OfKept::of(view.J_kept, row).residuals(kept);
      OfEliminated::of(view.J_eliminated, row).residuals(eliminated);
      for (int k = 0; k < R; ++k) {
        double J_e[E], U[E];
        eliminated[k].store(J_e);
        times_factor_transposed<E>(M, J_e, U);
        for (int i = 0; i < E; ++i) sums[i].add(U[i], kept[k]);
      }
    });
    const Index anchor = view.anchors.of_coupling[c];
    for (int k = 0; anchor >= 0 && k < E; ++k) {
      const auto Z = Row<K>::load(view.anchors.Z + (anchor * E + k) * K);
      for (int i = 0; i < E; ++i) sums[i].add(-M[k * E + i] * D[k], Z);
    }
    for (int i = 0; i < E; ++i) sums[i].store(W + i * K);
  }

  [[gnu::always_inline]] static void prefetch_coupling(const EliminationView& view, Index c) {
    constexpr int number = sizeof(T);
    prefetch<R * K * number>(OfKept::of(view.J_kept, row_begin(view.kept, c)).values);
    const Index anchor = view.anchors.of_coupling[c];
    if (anchor >= 0) prefetch<E * K * 8>(view.anchors.Z + anchor * E * K);
  }

  // v -= (J_k^T J_e - Z^T D) q.
  [[gnu::always_inline]] static void reduce(const EliminationView& view, Index e, Index c,
                                            Row<K>& v) {
    CouplingProducts<T, R, K, E, false>::reduce(view, e, c, v);
    const Index anchor = view.anchors.of_coupling[c];
    for (int k = 0; anchor >= 0 && k < E; ++k) {
      v.add(view.D[e * E + k] * view.q[e * E + k],
            Row<K>::load(view.anchors.Z + (anchor * E + k) * K));
    }
  }

  struct Left {
    Index coupling;
    double W[E * K];
  };
  template <class Visit>
  [[gnu::always_inline]] static void for_lefts(const EliminationView& view, Index e, Index c,
                                               Visit&& visit) {
    Left left;
    left.coupling = c;
    form(view, e, c, left.W);
    visit(left);
  }

  // A += Z_a^T D Z_b - W_a W_b^T, and J_a^T J_a where the two are the same.
  template <bool same, class Target>
  [[gnu::always_inline]] static void add(const EliminationView& view, Index e, const Left& left,
                                         Index other, const Target& A) {
    if constexpr (same) {
      for_rows_of(view.kept, other, [&](Index row) {
        double J[R * K];
        Row<K> right[R];
        OfKept::of(view.J_kept, row).residuals(right);
        for (int r = 0; r < R; ++r) right[r].store(J + r * K);
        A.template add<R>(J, right);
      });
    }
    const double* W = same ? left.W : view.W + other * E * K;
    Row<K> right[E] = {};
    for (int k = 0; k < E; ++k) right[k].add(-1, Row<K>::load(W + k * K));
    A.template add<E>(left.W, right);
    const Index a = view.anchors.of_coupling[left.coupling], b = view.anchors.of_coupling[other];
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
