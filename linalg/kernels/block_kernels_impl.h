// The kernels of kernel_table.h as plain loops with fixed trip counts. Included once per
// instruction set by a unit that defines RAYBUNDLE_ISA and is compiled for it; everything is local
// to that unit and nothing of the standard library is used, so that no code compiled for one
// instruction set can be linked in place of another's.
//
// R residuals per row, K unknowns per hub (or kept block), E per leaf (or eliminated block).

#pragma once

#include <raybundle/linalg/kernels/rows_impl.h>

namespace raybundle::linalg::RAYBUNDLE_ISA {
namespace {

template <int N>
inline void clear(double* x) {
  for (int i = 0; i < N; ++i) x[i] = 0;
}

// u += J x, with J of R x W.
template <int R, int W>
inline void add_product(const double* J, const double* x, double* u) {
  for (int r = 0; r < R; ++r) u[r] += Row<W>::dot(J + r * W, x);
}

// y += J^T u.
template <int R, int W>
inline void add_transpose_product(const double* J, const double* u, double* y) {
  auto sum = Row<W>::load(y);
  for (int r = 0; r < R; ++r) sum.add(u[r], Row<W>::load(J + r * W));
  sum.store(y);
}

// J_b^T u of one block of W unknowns.
template <int R, int W>
[[gnu::always_inline]] inline Row<W> transpose_product(const SideView& side, const double* J,
                                                       const double* u, Index b) {
  Row<W> sum = {};
  for_rows_ahead<R * W>(side, b, J, [&](Index row, Index) {
    for (int k = 0; k < R; ++k) {
      sum.add(u[row * R + k], Row<W>::load(J + (row * R + k) * W));
    }
  });
  return sum;
}

// J_b^T J_b and J_b^T r of one block.
template <int R, int W>
[[gnu::always_inline]] inline void squares(const SideView& side, const double* J, const double* r,
                                           Index b, Row<W>* block, Row<W>& gradient) {
  for_rows_ahead<R * W>(side, b, J, [&](Index row, Index) {
    for (int k = 0; k < R; ++k) {
      const double* J_row = J + (row * R + k) * W;
      const auto x = Row<W>::load(J_row);
#pragma GCC unroll 12
      for (int i = 0; i < W; ++i) block[i].add(J_row[i], x);
      gradient.add(r[row * R + k], x);
    }
  });
}

template <int W>
[[gnu::always_inline]] inline void store_block(const Row<W>* block, double* H) {
  for (int i = 0; i < W; ++i) block[i].store(H + i * W);
}

template <int R, int K, int E, bool anchored>
struct Blocks {
  static void multiply(const JacobianView& J, const double* x_hub, const double* x_leaf,
                       Index first, Index last, double* u) {
    for (Index b = first; b < last; ++b) {
      double felt[E];
      for (int i = 0; i < E; ++i) felt[i] = x_leaf[b * E + i];
      if constexpr (anchored) add_anchored<K, E>(J.anchors, b, J.hubs.block, x_hub, felt);
      for_rows(J.leaves, b, [&](Index row, Index c) {
        double sum[R] = {};
        add_product<R, K>(J.J_hub + row * R * K, x_hub + Index{J.hubs.block[c]} * K, sum);
        add_product<R, E>(J.J_leaf + row * R * E, felt, sum);
        for (int k = 0; k < R; ++k) u[row * R + k] = sum[k];
      });
    }
  }

  static void transpose_multiply_hubs(const JacobianView& J, const double* u, const double* w,
                                      Index first, Index last, double* y) {
    for (Index b = first; b < last; ++b) {
      Row<K> sum = transpose_product<R, K>(J.hubs, J.J_hub, u, b);
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
      transpose_product<R, E>(J.leaves, J.J_leaf, u, b).store(y + b * E);
    }
  }

  static void normal_blocks_leaves(const JacobianView& J, const double* r, Index first, Index last,
                                   const NormalView& normal) {
    for (Index b = first; b < last; ++b) {
      Row<E> block[E] = {}, gradient = {};
      squares<R, E>(J.leaves, J.J_leaf, r, b, block, gradient);
      store_block<E>(block, normal.C + b * E * E);
      gradient.store(normal.g_leaf + b * E);
      if constexpr (anchored) {
        for (Index k = J.anchors.begin[b]; k < J.anchors.begin[b + 1]; ++k) {
          anchor_products(J, k, normal.C + b * E * E, normal.g_leaf + b * E,
                          normal.products + k * (E + 1) * K);
        }
      }
    }
  }

  static void normal_blocks_hubs(const JacobianView& J, const double* r, Index first, Index last,
                                 const NormalView& normal) {
    for (Index b = first; b < last; ++b) {
      Row<K> block[K] = {}, gradient = {};
      squares<R, K>(J.hubs, J.J_hub, r, b, block, gradient);
      store_block<K>(block, normal.B + b * K * K);
      if constexpr (anchored) {
        gradient.store(normal.own_g_hub + b * K);
        Row<K> added = {};
        for_anchors(J, b, normal.products, [&](const double* Z, const double* F) {
          for (int j = 0; j < E; ++j) {
            added.add_products(Row<K>::load(F + j * K), Row<K>::load(Z + j * K));
          }
          gradient.add(1, Row<K>::load(F + E * K));
        });
        added.store(normal.diagonal + b * K);
        for (int i = 0; i < K; ++i) {
          double& d = normal.diagonal[b * K + i];
          d = normal.B[(b * K + i) * K + i] + 2 * d;
        }
      }
      gradient.store(normal.g_hub + b * K);
    }
  }

  // See NormalView.
  [[gnu::always_inline]] static void anchor_products(const JacobianView& J, Index k,
                                                     const double* C, const double* g,
                                                     double* products) {
    Row<K> F[E] = {}, Zg = {};
    for_rows_of(J.leaves, J.anchors.coupling[k], [&](Index row) {
      for (Index i = row * R; i < (row + 1) * R; ++i) {
        const auto x = Row<K>::load(J.J_hub + i * K);
        for (int j = 0; j < E; ++j) F[j].add(J.J_leaf[i * E + j], x);
      }
    });
    for (int m = 0; m < E; ++m) {
      const auto Z = Row<K>::load(J.anchors.Z + (k * E + m) * K);
      for (int j = 0; j < E; ++j) F[j].add(0.5 * C[j * E + m], Z);
      Zg.add(g[m], Z);
    }
    for (int j = 0; j < E; ++j) F[j].store(products + j * K);
    Zg.store(products + E * K);
  }

  // Calls visit(Z, F) for the anchors that hub b is.
  template <class Visit>
  [[gnu::always_inline]] static void for_anchors(const JacobianView& J, Index b,
                                                 const double* products, Visit&& visit) {
    constexpr int size = (E + 1) * K;
    for (Index p = J.hubs.begin[b]; p < J.hubs.begin[b + 1]; ++p) {
      const Index ahead = coupling_ahead(J.hubs, b, p);
      const Index next = ahead >= 0 ? J.anchors.of_coupling[ahead] : -1;
      if (next >= 0) {
        prefetch<E * K * 8>(J.anchors.Z + next * E * K);
        prefetch<size * 8>(products + next * size);
      }
      const Index k = J.anchors.of_coupling[coupling(J.hubs, p)];
      if (k >= 0) visit(J.anchors.Z + k * E * K, products + k * size);
    }
  }

  static void add_anchor_blocks(const JacobianView& J, const double* products, Index first,
                                Index last, double* H) {
    for (Index b = first; b < last; ++b) {
      Row<K> block[K];
      for (int i = 0; i < K; ++i) block[i] = Row<K>::load(H + (b * K + i) * K);
      for_anchors(J, b, products, [&](const double* Z, const double* F) {
        for (int j = 0; j < E; ++j) {
          const auto Z_j = Row<K>::load(Z + j * K), F_j = Row<K>::load(F + j * K);
#pragma GCC unroll 12
          for (int i = 0; i < K; ++i) {
            block[i].add(F[j * K + i], Z_j);
            block[i].add(Z[j * K + i], F_j);
          }
        }
      });
      store_block<K>(block, H + b * K * K);
    }
  }
};

template <int R, int HubSize, int LeafSize, bool anchored>
constexpr BlockKernels make_block_kernels() {
  using Kernels = Blocks<R, HubSize, LeafSize, anchored>;
  BlockKernels result = {&Kernels::multiply,
                         &Kernels::transpose_multiply_hubs,
                         &Kernels::transpose_multiply_leaves,
                         &Kernels::normal_blocks_hubs,
                         &Kernels::normal_blocks_leaves,
                         nullptr};
  if constexpr (anchored) result.add_anchor_blocks = &Kernels::add_anchor_blocks;
  return result;
}

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
