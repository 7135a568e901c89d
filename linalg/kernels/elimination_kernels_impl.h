// The kernels of an elimination; see kernel_table.h for what M, q and W are, block_kernels_impl.h
// for the rules of such a file. K unknowns per kept block, E per eliminated block.

#pragma once

#include <raybundle/linalg/kernels/coarse_kernels_impl.h>

namespace raybundle::linalg::RAYBUNDLE_ISA {
namespace {

// M with M M^T = A^-1 for one block; false when a pivot is not above tolerance * its diagonal.
template <int E>
inline bool inverse_factor(const double* A, double tolerance, double* M) {
  double L[E * E];
  for (int j = 0; j < E; ++j) {
    double pivot = A[j * E + j];
    for (int k = 0; k < j; ++k) pivot -= L[j * E + k] * L[j * E + k];
    if (!(pivot > tolerance * A[j * E + j]) || !(pivot < 1e300)) return false;
    const double root = __builtin_sqrt(pivot);
    const double inverse = 1 / root;
    L[j * E + j] = inverse;  // the inverse diagonal: all that is used of it
    for (int i = j + 1; i < E; ++i) {
      double sum = A[i * E + j];
      for (int k = 0; k < j; ++k) sum -= L[i * E + k] * L[j * E + k];
      L[i * E + j] = sum * inverse;
    }
  }
  for (int j = 0; j < E; ++j) {  // column j of L^-1 is row j of M = L^-T
    for (int i = 0; i < j; ++i) M[j * E + i] = 0;
    M[j * E + j] = L[j * E + j];
    for (int i = j + 1; i < E; ++i) {
      double sum = 0;
      for (int k = j; k < i; ++k) sum += L[i * E + k] * M[j * E + k];
      M[j * E + i] = -sum * L[i * E + i];
    }
  }
  return true;
}

template <class T, int R, int K, int E, bool anchored>
struct Eliminate {
  using Products = CouplingProducts<T, R, K, E, anchored>;
  using OfKept = RowBlock<T, R, K>;
  using OfEliminated = RowBlock<T, R, E>;

  static Index factor(const double* H, const double* d, double tolerance, Index first, Index last,
                      double* M, Index* failed) {
    Index failures = 0;
    for (Index e = first; e < last; ++e) {
      double A[E * E];
      for (int i = 0; i < E * E; ++i) A[i] = H[e * E * E + i];
      for (int i = 0; i < E; ++i) A[i * E + i] += d[e * E + i];
      if (!inverse_factor<E>(A, tolerance, M + e * E * E)) failed[failures++] = e;
    }
    return failures;
  }

  static void solve_own(const EliminationView& view, const double* g_eliminated, Index first,
                        Index last) {
    for (Index e = first; e < last; ++e) {
      solve_factored<E>(view.M + e * E * E, g_eliminated + e * E, view.q + e * E);
    }
  }

  static void couple(const EliminationView& view, Index first, Index last) {
    if constexpr (anchored) {
      for (Index e = first; e < last; ++e) {
        for (Index c = view.eliminated.begin[e]; c < view.eliminated.begin[e + 1]; ++c) {
          Products::form(view, e, c, view.W + c * E * K);
        }
      }
    }
  }

  static void reduce_gradient(const EliminationView& view, Index first, Index last, double* v) {
    for (Index a = first; a < last; ++a) {
      auto reduced = Row<K>::load(v + a * K);
      for (Index p = view.kept.begin[a]; p < view.kept.begin[a + 1]; ++p) {
        const Index ahead = coupling_ahead(view.kept, a, p);
        if (ahead >= 0) Products::prefetch_coupling(view, ahead);
        const Index c = coupling(view.kept, p);
        Products::reduce(view, view.eliminated.block[c], c, reduced);
      }
      reduced.store(v + a * K);
    }
  }

  // w = J_e^T u of one eliminated block, with u = J_k x in its rows and x_of(kept block) as
  // operand.
  template <class X, class Store>
  [[gnu::always_inline]] static void feel(const EliminationView& view, X&& x_of, Index e, double* w,
                                          Store&& store) {
    typename OfEliminated::Operand sums = {};
    for_rows(view.eliminated, e, [&](Index row, Index c) {
      const OfKept kept = OfKept::of(view.J_kept, row);
      const OfEliminated eliminated = OfEliminated::of(view.J_eliminated, row);
      prefetch_ahead(kept);
      prefetch_ahead(eliminated);
      const Row<R> u = kept.times(x_of(Index{view.kept.block[c]}));
      eliminated.add_transposed(u, sums);
      store(row, u);
    });
    OfEliminated::collect(sums, w);
  }

  // u - J_e s in one row, with -s as operand.
  [[gnu::always_inline]] static Row<R> less(Row<R> u, const EliminationView& view, Index row,
                                            const typename OfEliminated::Operand& minus_s) {
    u.add(1, OfEliminated::of(view.J_eliminated, row).times(minus_s));
    return u;
  }
  [[gnu::always_inline]] static typename OfEliminated::Operand minus(const double* s) {
    double x[E];
    for (int i = 0; i < E; ++i) x[i] = -s[i];
    return OfEliminated::spread(x);
  }

  // z = Z x of an anchored leaf, whose damping makes w = J_e^T u less by D z.
  template <class X>
  [[gnu::always_inline]] static void hold(const EliminationView& view, Index e, X&& x_of, double* w,
                                          double* z) {
    clear<E>(z);
    if constexpr (anchored) {
      add_anchored<K, E>(view.anchors, e, view.kept.block, x_of, z);
      for (int i = 0; i < E; ++i) w[i] -= view.D[e * E + i] * z[i];
    }
  }

  // Puts the parts of u = J_k x side by side, for a second walk over the rows of the same block.
  struct Aside {
    double* to;
    [[gnu::always_inline]] void operator()(Index /*row*/, const Row<R>& of_row) {
      of_row.store(to);
      to += R;
    }
  };

  static void project(const EliminationView& view, const double* x_kept, Index first, Index last,
                      double* u) {
    const auto x_of = [&](Index k) { return OfKept::spread(Row<K>::load(x_kept + k * K)); };
    const auto store = [&](Index row, const Row<R>& of_row) { of_row.store(u + row * R); };
    for (Index e = first; e < last; ++e) {
      double w[E], s[E];
      feel(view, x_of, e, w, store);
      solve_factored<E>(view.M + e * E * E, w, s);
      const auto minus_s = minus(s);
      for_rows(view.eliminated, e, [&](Index row, Index) {
        less(Row<R>::load(u + row * R), view, row, minus_s).store(u + row * R);
      });
    }
  }

  // Of its own copy of the view: what is stored could otherwise change it, as far as a compiler
  // knows.
  static void multiply(const EliminationView& given, const double* x, Index first, Index last,
                       double* u, double* y) {
    using Operand = typename OfKept::Operand;
    constexpr Index stride = OfKept::operand;
    const EliminationView view = given;
    const auto x_of = [&](Index k) { return Operand::load(x + k * stride); };
    for (Index e = first; e < last; ++e) {
      double w[E], z[E], s[E];
      feel(view, x_of, e, w, Aside{u});
      hold(
          view, e, [&](Index k) { return plain(x_of(k)); }, w, z);
      solve_factored<E>(view.M + e * E * E, w, s);
      const auto minus_s = minus(s);
      const double* of_row = u;
      for_rows(view.eliminated, e, [&](Index row, Index c) {
        double* y_kept = y + Index{view.kept.block[c]} * stride;
        auto sum = Operand::load(y_kept);
        const Row<R> rest = less(Row<R>::load(of_row), view, row, minus_s);
        OfKept::of(view.J_kept, row).add_transposed(rest, sum);
        sum.store(y_kept);
        of_row += R;
      });
      if constexpr (anchored) add_held(view, e, s, z, y);
    }
  }

  // Of an operand that is read, and one that is written.
  [[gnu::always_inline]] static Row<K> plain(const typename OfKept::Operand& x) {
    if constexpr (in_pairs(R)) {
      return deinterleave<0>(x);
    } else {
      return x;
    }
  }
  [[gnu::always_inline]] static void add_plain(const Row<K>& x, double* y) {
    using Operand = typename OfKept::Operand;
    auto sum = Operand::load(y);
    if constexpr (in_pairs(R)) {
      sum.add(1, interleave(x, Row<K>{}));
    } else {
      sum.add(1, x);
    }
    sum.store(y);
  }

  // y += Z^T D (z + s).
  [[gnu::always_inline]] static void add_held(const EliminationView& view, Index e, const double* s,
                                              const double* z, double* y) {
    double w[E];
    for (int i = 0; i < E; ++i) w[i] = view.D[e * E + i] * (z[i] + s[i]);
    for (Index k = view.anchors.begin[e]; k < view.anchors.begin[e + 1]; ++k) {
      Row<K> sum = {};
      add_anchor_transposed<K, E>(view.anchors, k, w, sum);
      add_plain(sum, y + Index{view.kept.block[view.anchors.coupling[k]]} * OfKept::operand);
    }
  }

  static double back_substitute(const EliminationView& view, const double* x_kept, Index first,
                                Index last, double* u, double* x_eliminated) {
    const auto plain_x = [&](Index k) { return Row<K>::load(x_kept + k * K); };
    const auto x_of = [&](Index k) { return OfKept::spread(plain_x(k)); };
    Row<R> squares = {};
    for (Index e = first; e < last; ++e) {
      double w[E], z[E], s[E];
      feel(view, x_of, e, w, Aside{u});
      hold(view, e, plain_x, w, z);
      solve_factored<E>(view.M + e * E * E, w, s);
      for (int i = 0; i < E; ++i) {
        s[i] += view.q[e * E + i];
        x_eliminated[e * E + i] = -s[i] - z[i];
      }
      const auto minus_s = minus(s);
      const double* of_row = u;  // -J_e s: of anchored leaves what their rows feel
      for_rows(view.eliminated, e, [&](Index row, Index) {
        const Row<R> moved = less(Row<R>::load(of_row), view, row, minus_s);
        squares.add_products(moved, moved);
        of_row += R;
      });
    }
    return squares.sum();
  }

  static void add_products(const EliminationView& view, Index a, const BlockRowView& block_row,
                           double* v) {
    auto reduced = Row<K>::load(v + a * K);
    for (Index p = view.kept.begin[a]; p < view.kept.begin[a + 1]; ++p) {
      const Index ahead = coupling_ahead(view.kept, a, p);
      if (ahead >= 0) Products::prefetch_coupling(view, ahead);
      const Index c = coupling(view.kept, p);
      const Index e = view.eliminated.block[c];
      Products::reduce(view, e, c, reduced);
      const auto block = [&](Index other) {
        const Index slot = block_row.slot_of[view.kept.block[other]];
        return Square<K>{block_row.values + slot * K, block_row.stride};
      };
      Products::for_lefts(view, e, c, [&](const typename Products::Left& left) {
        Products::template add<true>(view, e, left, c, block(c));
        for (Index q = position(view.eliminated, c) + 1; q < view.eliminated.begin[e + 1]; ++q) {
          const Index other = coupling(view.eliminated, q);
          Products::template add<false>(view, e, left, other, block(other));
        }
      });
    }
    reduced.store(v + a * K);
  }

  static void add_diagonal(const EliminationView& view, Index first, Index last, double* sums) {
    constexpr int triangle = triangle_size(K), size = triangle + K;
    const Index end = view.eliminated.begin[last];
    for (Index e = first; e < last; ++e) {
      for (Index p = view.eliminated.begin[e]; p < view.eliminated.begin[e + 1]; ++p) {
        const Index ahead = coupling(view.eliminated, p + lookahead < end ? p + lookahead : p);
        prefetch<8 * size>(sums + Index{view.kept.block[ahead]} * size);
        const Index c = coupling(view.eliminated, p);
        prefetch_ahead(OfKept::of(view.J_kept, row_begin(view.kept, c)));
        prefetch_ahead(OfEliminated::of(view.J_eliminated, row_begin(view.kept, c)));
        double* A = sums + Index{view.kept.block[c]} * size;
        Products::for_lefts(view, e, c, [&](const typename Products::Left& left) {
          Products::template add<true>(view, e, left, c, Triangle<K>{A});
        });
        auto v = Row<K>::load(A + triangle);
        Products::reduce(view, e, c, v);
        v.store(A + triangle);
      }
    }
  }

  static void diagonal_blocks(const EliminationView& view, Index first, Index last,
                              double* A_diagonal) {
    for (Index a = first; a < last; ++a) {
      double* A = A_diagonal + a * K * K;
      clear<K * K>(A);
      for_couplings(view.kept, a, [&](Index c) {
        const Index e = view.eliminated.block[c];
        Products::for_lefts(view, e, c, [&](const typename Products::Left& left) {
          Products::template add<true>(view, e, left, c, Square<K>{A, K});
        });
      });
    }
  }

  static void coupling_block(const EliminationView& view, Index c, double* block, Index stride) {
    Row<E> product[K] = {};
    for_rows_of(view.kept, c, [&](Index row) {
      Row<K> kept[R];
      Row<E> eliminated[R];
      OfKept::of(view.J_kept, row).residuals(kept);
      OfEliminated::of(view.J_eliminated, row).residuals(eliminated);
      for (int k = 0; k < R; ++k) {
        for (int i = 0; i < K; ++i) product[i].add(kept[k][i], eliminated[k]);
      }
    });
    for (int i = 0; i < K; ++i) product[i].store(block + i * stride);
  }
};

template <class T, int R, int K, int E, bool anchored>
constexpr EliminationKernels make_elimination_kernels() {
  using Kernels = Eliminate<T, R, K, E, anchored>;
  return {
      &Kernels::factor,          &Kernels::solve_own,      &Kernels::couple,
      &Kernels::reduce_gradient, &Kernels::project,        &Kernels::multiply,
      &Kernels::back_substitute, &Kernels::add_products,   &Kernels::add_diagonal,
      &Kernels::diagonal_blocks, &Kernels::coupling_block, coarse_products<T, R, K, E, anchored>()};
}

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
