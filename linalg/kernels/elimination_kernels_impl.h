// The kernels of an elimination; see kernel_table.h for what U, y and W are, block_kernels_impl.h
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

template <int R, int K, int E, bool anchored>
struct Eliminate {
  using Products = CouplingProducts<R, K, E, anchored>;

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

  static void transform(const EliminationView& view, const double* g_eliminated, Index first,
                        Index last) {
    for (Index e = first; e < last; ++e) {
      const double* M = view.M + e * E * E;
      clear<E>(view.y + e * E);
      add_transpose_product<E, E>(M, g_eliminated + e * E, view.y + e * E);
      for_rows(view.eliminated, e, [&](Index row, Index) {
        prefetch_ahead<R * E>(view.J_eliminated + row * R * E);
        double* Ut = view.U + row * R * E;
        for (int k = 0; k < R; ++k) {
          double of_residual[E] = {};
          add_transpose_product<E, E>(M, view.J_eliminated + (row * R + k) * E, of_residual);
          for (int i = 0; i < E; ++i) Ut[i * R + k] = of_residual[i];
        }
      });
      Products::form(view, e);
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

  // t += U^T J_k x for one eliminated block, with u = J_k x in its rows.
  template <class Store>
  [[gnu::always_inline]] static void feel(const EliminationView& view, const double* x_kept,
                                          Index e, double* t, Store&& store) {
    Row<R> sums[E] = {};
    for_rows(view.eliminated, e, [&](Index row, Index c) {
      const double* Ut = view.U + row * R * E;
      prefetch_ahead<R * K>(view.J_kept + row * R * K);
      prefetch_ahead<R * E>(Ut);
      const auto x = Row<K>::load(x_kept + Index{view.kept.block[c]} * K);
      const Row<R> u = product<R, K>(view.J_kept + row * R * K, x);
      for (int i = 0; i < E; ++i) sums[i].add_products(Row<R>::load(Ut + i * R), u);
      store(row, u);
    });
    for (int i = 0; i < E; ++i) t[i] += sums[i].sum();
  }

  // u - U t in one row.
  [[gnu::always_inline]] static Row<R> less(Row<R> u, const double* Ut, const double* t) {
    for (int i = 0; i < E; ++i) u.add(-t[i], Row<R>::load(Ut + i * R));
    return u;
  }

  // t -= M^T D z with z = Z x: what the damping of an anchored leaf adds to U^T J_k x.
  [[gnu::always_inline]] static void hold(const EliminationView& view, Index e, const double* z,
                                          double* t) {
    for (int k = 0; k < E; ++k) {
      for (int i = 0; i < E; ++i) t[i] -= view.M[(e * E + k) * E + i] * view.D[e * E + k] * z[k];
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
    for (Index e = first; e < last; ++e) {
      double t[E] = {};
      feel(view, x_kept, e, t, [&](Index row, const Row<R>& of_row) { of_row.store(u + row * R); });
      for_rows(view.eliminated, e, [&](Index row, Index) {
        less(Row<R>::load(u + row * R), view.U + row * R * E, t).store(u + row * R);
      });
    }
  }

  static void multiply(const EliminationView& view, const double* x_kept, Index first, Index last,
                       double* u, double* y) {
    for (Index e = first; e < last; ++e) {
      double t[E] = {}, z[E] = {};
      feel(view, x_kept, e, t, Aside{u});
      if constexpr (anchored) {
        add_anchored<K, E>(view.anchors, e, view.kept.block, x_kept, z);
        hold(view, e, z, t);
      }
      const double* of_row = u;
      for_rows(view.eliminated, e, [&](Index row, Index c) {
        double* y_kept = y + Index{view.kept.block[c]} * K;
        const Row<R> rest = less(Row<R>::load(of_row), view.U + row * R * E, t);
        auto sum = Row<K>::load(y_kept);
        for (int k = 0; k < R; ++k) {
          sum.add(rest[k], Row<K>::load(view.J_kept + (row * R + k) * K));
        }
        sum.store(y_kept);
        of_row += R;
      });
      if constexpr (anchored) add_held(view, e, t, z, y);
    }
  }

  // y += Z^T D (z + M t).
  [[gnu::always_inline]] static void add_held(const EliminationView& view, Index e, const double* t,
                                              const double* z, double* y) {
    double w[E];
    for (int i = 0; i < E; ++i) {
      w[i] = view.D[e * E + i] * (z[i] + Row<E>::dot(view.M + (e * E + i) * E, t));
    }
    for (Index k = view.anchors.begin[e]; k < view.anchors.begin[e + 1]; ++k) {
      double* y_kept = y + Index{view.kept.block[view.anchors.coupling[k]]} * K;
      auto sum = Row<K>::load(y_kept);
      add_anchor_transposed<K, E>(view.anchors, k, w, sum);
      sum.store(y_kept);
    }
  }

  static double back_substitute(const EliminationView& view, const double* x_kept, Index first,
                                Index last, double* u, double* x_eliminated) {
    double squares = 0;
    for (Index e = first; e < last; ++e) {
      double t[E], z[E] = {};
      for (int i = 0; i < E; ++i) t[i] = view.y[e * E + i];
      feel(view, x_kept, e, t, Aside{u});
      if constexpr (anchored) {
        add_anchored<K, E>(view.anchors, e, view.kept.block, x_kept, z);
        hold(view, e, z, t);
      }
      for (int i = 0; i < E; ++i) {
        x_eliminated[e * E + i] = -Row<E>::dot(view.M + (e * E + i) * E, t) - z[i];
      }
      const double* of_row = u;  // J_e x_e = -U t, of anchored leaves what their rows feel
      for_rows(view.eliminated, e, [&](Index row, Index) {
        const Row<R> moved = less(Row<R>::load(of_row), view.U + row * R * E, t);
        for (int k = 0; k < R; ++k) squares += moved[k] * moved[k];
        of_row += R;
      });
    }
    return squares;
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
      Products::template add<true>(view, e, c, c, block(c));
      for (Index q = position(view.eliminated, c) + 1; q < view.eliminated.begin[e + 1]; ++q) {
        const Index other = coupling(view.eliminated, q);
        Products::template add<false>(view, e, c, other, block(other));
      }
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
        prefetch_ahead<R * K>(view.J_kept + row_begin(view.kept, c) * R * K);
        prefetch_ahead<R * E>(view.U + row_begin(view.kept, c) * R * E);
        double* A = sums + Index{view.kept.block[c]} * size;
        Products::template add<true>(view, e, c, c, Triangle<K>{A});
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
        Products::template add<true>(view, view.eliminated.block[c], c, c, Square<K>{A, K});
      });
    }
  }

  static void coupling_block(const EliminationView& view, Index c, double* block, Index stride) {
    Row<E> product[K] = {};
    for_rows_of(view.kept, c, [&](Index row) {
      for (Index k = row * R; k < (row + 1) * R; ++k) {
        const auto J_e = Row<E>::load(view.J_eliminated + k * E);
        for (int i = 0; i < K; ++i) product[i].add(view.J_kept[k * K + i], J_e);
      }
    });
    for (int i = 0; i < K; ++i) product[i].store(block + i * stride);
  }
};

template <int R, int K, int E, bool anchored>
constexpr EliminationKernels make_elimination_kernels() {
  using Kernels = Eliminate<R, K, E, anchored>;
  return {&Kernels::factor,
          &Kernels::transform,
          &Kernels::reduce_gradient,
          &Kernels::project,
          &Kernels::multiply,
          &Kernels::back_substitute,
          &Kernels::add_products,
          &Kernels::add_diagonal,
          &Kernels::diagonal_blocks,
          &Kernels::coupling_block,
          coarse_products<R, K, E, anchored>()};
}

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
