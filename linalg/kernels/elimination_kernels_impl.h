// The kernels of an elimination; see kernel_table.h for what M, q and W are, block_kernels_impl.h
// for the rules of such a file. K unknowns per kept block, E per eliminated block.

#pragma once

#include <raybundle/linalg/kernels/coupling_products_impl.h>

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

  // M M^T w.
  [[gnu::always_inline]] static Row<E> solve(const EliminationView& view, Index e,
                                             const Row<E>& w) {
    const double* M = view.M + e * E * E;
    return times_factor<E>(M, times_factor_transposed<E>(M, w));
  }

  static void solve_own(const EliminationView& view, const double* g_eliminated, Index first,
                        Index last) {
    for (Index e = first; e < last; ++e) {
      solve(view, e, Row<E>::load(g_eliminated + e * E)).store(view.q + e * E);
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

  // J_e^T u of one eliminated block, with u = J_k x in its rows.
  template <class Store>
  [[gnu::always_inline]] static Row<E> feel(const EliminationView& view, const double* x_kept,
                                            Index e, Store&& store) {
    typename OfEliminated::Sums sums;
    for_rows(view.eliminated, e, [&](Index row, Index c) {
      const OfKept kept = OfKept::of(view.J_kept, row);
      const OfEliminated eliminated = OfEliminated::of(view.J_eliminated, row);
      prefetch_ahead(kept);
      prefetch_ahead(eliminated);
      const Row<R> u = kept.times(Row<K>::load(x_kept + Index{view.kept.block[c]} * K));
      sums.add(eliminated, u);
      store(row, u);
    });
    return sums.total();
  }

  // u - J_e s in one row.
  [[gnu::always_inline]] static Row<R> less(Row<R> u, const EliminationView& view, Index row,
                                            const Row<E>& s) {
    u.add(-1, OfEliminated::of(view.J_eliminated, row).times(s));
    return u;
  }

  // z = Z x of an anchored leaf, whose damping makes w = J_e^T u less by D z.
  [[gnu::always_inline]] static Row<E> hold(const EliminationView& view, Index e,
                                            const double* x_kept, Row<E>& w) {
    double z[E] = {};
    if constexpr (anchored) {
      add_anchored<K, E>(view.anchors, e, view.kept.block, x_kept, z);
      double held[E];
      for (int i = 0; i < E; ++i) held[i] = view.D[e * E + i] * z[i];
      w.add(-1, Row<E>::load(held));
    }
    return Row<E>::load(z);
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
    for (Index e = first; e < last; ++e) {
      const Row<E> s = solve(view, e, feel(view, x_kept, e, [&](Index row, const Row<R>& of_row) {
                               of_row.store(u + row * R);
                             }));
      for_rows(view.eliminated, e, [&](Index row, Index) {
        less(Row<R>::load(u + row * R), view, row, s).store(u + row * R);
      });
    }
  }

  static void multiply(const EliminationView& view, const double* x_kept, Index first, Index last,
                       double* u, double* y) {
    for (Index e = first; e < last; ++e) {
      Row<E> w = feel(view, x_kept, e, Aside{u});
      const Row<E> z = hold(view, e, x_kept, w);
      const Row<E> s = solve(view, e, w);
      const double* of_row = u;
      for_rows(view.eliminated, e, [&](Index row, Index c) {
        double* y_kept = y + Index{view.kept.block[c]} * K;
        auto sum = Row<K>::load(y_kept);
        OfKept::of(view.J_kept, row)
            .add_transposed(less(Row<R>::load(of_row), view, row, s), sum);
        sum.store(y_kept);
        of_row += R;
      });
      if constexpr (anchored) add_held(view, e, s, z, y);
    }
  }

  // y += Z^T D (z + s).
  [[gnu::always_inline]] static void add_held(const EliminationView& view, Index e, Row<E> s,
                                              const Row<E>& z, double* y) {
    s.add(1, z);
    double w[E];
    for (int i = 0; i < E; ++i) w[i] = view.D[e * E + i] * s[i];
    for (Index k = view.anchors.begin[e]; k < view.anchors.begin[e + 1]; ++k) {
      double* y_kept = y + Index{view.kept.block[view.anchors.coupling[k]]} * K;
      auto sum = Row<K>::load(y_kept);
      add_anchor_transposed<K, E>(view.anchors, k, w, sum);
      sum.store(y_kept);
    }
  }

  static double back_substitute(const EliminationView& view, const double* x_kept, Index first,
                                Index last, double* u, double* x_eliminated) {
    Row<R> squares = {};
    for (Index e = first; e < last; ++e) {
      Row<E> w = feel(view, x_kept, e, Aside{u});
      const Row<E> z = hold(view, e, x_kept, w);
      Row<E> s = solve(view, e, w);
      s.add(1, Row<E>::load(view.q + e * E));
      Row<E> x = {};
      x.add(-1, s);
      x.add(-1, z);
      x.store(x_eliminated + e * E);
      const double* of_row = u;  // -J_e s: of anchored leaves what their rows feel
      for_rows(view.eliminated, e, [&](Index row, Index) {
        const Row<R> moved = less(Row<R>::load(of_row), view, row, s);
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
      const OfKept kept = OfKept::of(view.J_kept, row);
      const OfEliminated eliminated = OfEliminated::of(view.J_eliminated, row);
      for (int k = 0; k < R; ++k) {
        const Row<K> of_kept = kept.residual(k);
        const Row<E> of_eliminated = eliminated.residual(k);
        for (int i = 0; i < K; ++i) product[i].add(of_kept[i], of_eliminated);
      }
    });
    for (int i = 0; i < K; ++i) product[i].store(block + i * stride);
  }
};

template <class T, int R, int K, int E, bool anchored>
constexpr EliminationKernels make_elimination_kernels() {
  using Kernels = Eliminate<T, R, K, E, anchored>;
  return {&Kernels::factor,          &Kernels::solve_own,       &Kernels::couple,
          &Kernels::reduce_gradient, &Kernels::project,         &Kernels::multiply,
          &Kernels::back_substitute, &Kernels::add_products,    &Kernels::add_diagonal,
          &Kernels::diagonal_blocks, &Kernels::coupling_block};
}

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
