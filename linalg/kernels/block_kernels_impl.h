// The kernels of kernel_table.h as plain loops with fixed trip counts. Included once per
// instruction set and precision by a unit that defines RAYBUNDLE_ISA and is compiled for it;
// everything is local to that unit and nothing of the standard library is used, so that no code
// compiled for one instruction set can be linked in place of another's.
//
// Rows of numbers T, R residuals each; K unknowns per hub (or kept block), E per leaf (or
// eliminated block).

#pragma once

#include <raybundle/linalg/kernels/rows_impl.h>

namespace raybundle::linalg::RAYBUNDLE_ISA {
namespace {

template <int N>
inline void clear(double* x) {
  for (int i = 0; i < N; ++i) x[i] = 0;
}

// block += x^T x.
template <int W>
[[gnu::always_inline]] inline void add_square(const Row<W>& x, Row<W>* block) {
#pragma GCC unroll 12
  for (int i = 0; i < W; ++i) block[i].add(x[i], x);
}

template <int W>
[[gnu::always_inline]] inline void store_block(const Row<W>* block, double* H) {
  for (int i = 0; i < W; ++i) block[i].store(H + i * W);
}

template <class T, int R, int K, int E, bool anchored>
struct Blocks {
  using OfHub = RowBlock<T, R, K>;
  using OfLeaf = RowBlock<T, R, E>;

  // Calls visit(row, (J x)_row) for the rows of leaves [first, last).
  template <class Visit>
  [[gnu::always_inline]] static void for_products(const JacobianView& J, const double* x_hub,
                                                  const double* x_leaf, Index first, Index last,
                                                  Visit&& visit) {
    for (Index b = first; b < last; ++b) {
      double felt[E];
      for (int i = 0; i < E; ++i) felt[i] = x_leaf[b * E + i];
      const auto x_of = [&](Index hub) { return Row<K>::load(x_hub + hub * K); };
      if constexpr (anchored) add_anchored<K, E>(J.anchors, b, J.hubs.block, x_of, felt);
      const auto of_leaf = OfLeaf::spread(Row<E>::load(felt));
      for_rows(J.leaves, b, [&](Index row, Index c) {
        const auto x = OfHub::spread(x_of(J.hubs.block[c]));
        Row<R> u = OfHub::of(J.J_hub, row).times(x);
        u.add(1, OfLeaf::of(J.J_leaf, row).times(of_leaf));
        visit(row, u);
      });
    }
  }

  static void multiply(const JacobianView& J, const double* x_hub, const double* x_leaf,
                       Index first, Index last, double* u) {
    for_products(J, x_hub, x_leaf, first, last,
                 [&](Index row, const Row<R>& of_row) { of_row.store(u + row * R); });
  }

  static double squares(const JacobianView& J, const double* x_hub, const double* x_leaf,
                        Index first, Index last) {
    Row<R> sum = {};
    for_products(J, x_hub, x_leaf, first, last,
                 [&](Index /*row*/, const Row<R>& of_row) { sum.add_products(of_row, of_row); });
    return sum.sum();
  }

  static void transpose_multiply_hubs(const JacobianView& J, const double* u, const double* w,
                                      Index first, Index last, double* y) {
    for (Index b = first; b < last; ++b) {
      typename OfHub::Operand sums = {};
      for_blocks_ahead<OfHub>(J.hubs, b, J.J_hub, [&](const OfHub& block, Index row, Index) {
        block.add_transposed(Row<R>::load(u + row * R), sums);
      });
      Row<K> sum = OfHub::collect(sums);
      if constexpr (anchored) {
        for_couplings(J.hubs, b, [&](Index c) {
          const Index k = J.anchors.of_coupling[c];
          if (k >= 0) add_anchor_transposed<K, E>(J.anchors, k, w + J.leaves.block[c] * E, sum);
        });
      }
      sum.store(y + b * K);
    }
  }

  static void transpose_multiply_leaves(const JacobianView& J, const double* u, Index first,
                                        Index last, double* y) {
    for (Index b = first; b < last; ++b) {
      typename OfLeaf::Operand sums = {};
      for_blocks_ahead<OfLeaf>(J.leaves, b, J.J_leaf, [&](const OfLeaf& block, Index row, Index) {
        block.add_transposed(Row<R>::load(u + row * R), sums);
      });
      OfLeaf::collect(sums).store(y + b * E);
    }
  }

  // The rows of a leaf: [first, last).
  struct Rows {
    Index first;
    Index last;
  };
  static Rows rows_of(const SideView& leaves, Index b) {
    if (leaves.begin[b] == leaves.begin[b + 1]) return {0, 0};
    return {row_begin(leaves, leaves.begin[b]), row_end(leaves, leaves.begin[b + 1] - 1)};
  }

  static void absorb(const JacobianView& J, const RowTile& tile, Index first, Index last,
                     const NormalView& normal) {
    for (Index b = first; b < last; ++b) {
      const Rows own = rows_of(J.leaves, b);
      double* C = normal.C + b * E * E;
      double* g = normal.g_leaf + b * E;
      Row<E> block[E] = {}, gradient = {};
      if (own.first < own.last && own.first < tile.first) {
        for (int i = 0; i < E; ++i) block[i] = Row<E>::load(C + i * E);
        gradient = Row<E>::load(g);
      }
      for_rows(J.leaves, b, [&](Index row, Index c) {
        if (row < tile.first || row >= tile.last) return;
        double* of_hub = normal.of_hubs + Index{J.hubs.block[c]} * K * sums_of_hub(anchored);
        absorb_row(J, tile, row, of_hub, block, gradient);
      });
      store_block<E>(block, C);
      gradient.store(g);
      if constexpr (anchored) {
        if (own.last <= tile.last) add_anchors(J, b, C, g, normal.of_hubs);
      }
    }
  }

  [[gnu::always_inline]] static void absorb_row(const JacobianView& J, const RowTile& tile,
                                                Index row, double* of_hub, Row<E>* block,
                                                Row<E>& gradient) {
    const Index at = (row - tile.first) * R;
    Row<K> hub[R];
    Row<E> leaf[R];
    auto diagonal = Row<K>::load(of_hub), own = Row<K>::load(of_hub + K);
    for (int k = 0; k < R; ++k) {
      const double r = tile.residual[at + k];
      hub[k] = Row<K>::load(tile.J_hub + (at + k) * K);
      leaf[k] = Row<E>::load(tile.J_leaf + (at + k) * E);
      own.add(r, hub[k]);
      gradient.add(r, leaf[k]);
    }
    OfHub::of(J.J_hub, row).store(hub);
    OfLeaf::of(J.J_leaf, row).store(leaf);
    OfHub::of(J.J_hub, row).residuals(hub);
    OfLeaf::of(J.J_leaf, row).residuals(leaf);
    for (int k = 0; k < R; ++k) {
      diagonal.add_products(hub[k], hub[k]);
      add_square<E>(leaf[k], block);
    }
    diagonal.store(of_hub);
    own.store(of_hub + K);
  }

  // F = J_leaf^T J_hub + 1/2 C Z of an anchor, by which it adds F^T Z + Z^T F to the block of J^T J
  // of its hub.
  [[gnu::always_inline]] static void anchor_product(const JacobianView& J, Index k, const double* C,
                                                    Row<K>* F) {
    for_rows_of(J.leaves, J.anchors.coupling[k], [&](Index row) {
      Row<K> of_hub[R];
      Row<E> of_leaf[R];
      OfHub::of(J.J_hub, row).residuals(of_hub);
      OfLeaf::of(J.J_leaf, row).residuals(of_leaf);
      for (int i = 0; i < R; ++i) {
        for (int j = 0; j < E; ++j) F[j].add(of_leaf[i][j], of_hub[i]);
      }
    });
    for (int m = 0; m < E; ++m) {
      const auto Z = Row<K>::load(J.anchors.Z + (k * E + m) * K);
      for (int j = 0; j < E; ++j) F[j].add(0.5 * C[j * E + m], Z);
    }
  }

  // What the anchors of a leaf add to the diagonal of their hubs, and to the gradient: Z^T g.
  [[gnu::always_inline]] static void add_anchors(const JacobianView& J, Index b, const double* C,
                                                 const double* g, double* of_hubs) {
    for (Index k = J.anchors.begin[b]; k < J.anchors.begin[b + 1]; ++k) {
      double* sums = of_hubs + Index{J.hubs.block[J.anchors.coupling[k]]} * K * sums_of_hub(true);
      auto diagonal = Row<K>::load(sums), gradient = Row<K>::load(sums + 2 * K);
      Row<K> F[E] = {};
      anchor_product(J, k, C, F);
      for (int m = 0; m < E; ++m) {
        const auto Z = Row<K>::load(J.anchors.Z + (k * E + m) * K);
        diagonal.add_products(F[m], Z);
        diagonal.add_products(F[m], Z);
        gradient.add(g[m], Z);
      }
      diagonal.store(sums);
      gradient.store(sums + 2 * K);
    }
  }

  static void hub_squares(const JacobianView& J, const double* C, Index first, Index last,
                          double* H) {
    for (Index b = first; b < last; ++b) {
      Row<K> block[K] = {};
      for_blocks_ahead<OfHub>(J.hubs, b, J.J_hub, [&](const OfHub& row, Index, Index) {
        Row<K> residuals[R];
        row.residuals(residuals);
        for (int k = 0; k < R; ++k) add_square<K>(residuals[k], block);
      });
      if constexpr (anchored) {
        for_couplings(J.hubs, b, [&](Index c) {
          const Index k = J.anchors.of_coupling[c];
          if (k >= 0) add_anchor_squares(J, k, C + Index{J.leaves.block[c]} * E * E, block);
        });
      }
      store_block<K>(block, H + b * K * K);
    }
  }

  [[gnu::always_inline]] static void add_anchor_squares(const JacobianView& J, Index k,
                                                        const double* C, Row<K>* block) {
    Row<K> F[E] = {};
    anchor_product(J, k, C, F);
    for (int j = 0; j < E; ++j) {
      const double* Z_j = J.anchors.Z + (k * E + j) * K;
      double F_j[K];
      F[j].store(F_j);
#pragma GCC unroll 12
      for (int i = 0; i < K; ++i) {
        block[i].add(F_j[i], Row<K>::load(Z_j));
        block[i].add(Z_j[i], F[j]);
      }
    }
  }
};

template <class T, int R, int HubSize, int LeafSize, bool anchored>
constexpr BlockKernels make_block_kernels() {
  using Kernels = Blocks<T, R, HubSize, LeafSize, anchored>;
  return {&Kernels::multiply,
          &Kernels::squares,
          &Kernels::transpose_multiply_hubs,
          &Kernels::transpose_multiply_leaves,
          &Kernels::absorb,
          &Kernels::hub_squares};
}

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
