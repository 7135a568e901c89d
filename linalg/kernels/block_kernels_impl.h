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
    }
  }

  static void normal_blocks_hubs(const JacobianView& J, const double* r, Index first, Index last,
                                 const NormalView& normal) {
    for (Index b = first; b < last; ++b) {
      Row<K> block[K] = {}, gradient = {};
      squares<R, K>(J.hubs, J.J_hub, r, b, block, gradient);
      if constexpr (anchored) {
        store_block<K>(block, normal.own_B + b * K * K);
        gradient.store(normal.own_g_hub + b * K);
        for_couplings(J.hubs, b, [&](Index c) {
          const Index k = J.anchors.of_coupling[c];
          if (k < 0) return;
          const Index leaf = J.leaves.block[c];
          add_anchor_block(J, c, k, normal.C + leaf * E * E, block);
          add_anchor_transposed<K, E>(J.anchors, k, normal.g_leaf + leaf * E, gradient);
        });
      }
      store_block<K>(block, normal.B + b * K * K);
      gradient.store(normal.g_hub + b * K);
    }
  }

  // B += E Z + Z^T E^T + Z^T C Z of one anchor, with E = J_hub^T J_leaf of its coupling.
  [[gnu::always_inline]] static void add_anchor_block(const JacobianView& J, Index c, Index k,
                                                      const double* C, Row<K>* B) {
    Row<K> E_transposed[E] = {}, Z[E];
    for_rows_of(J.hubs, c, [&](Index row) {
      for (Index i = row * R; i < (row + 1) * R; ++i) {
        const auto x = Row<K>::load(J.J_hub + i * K);
        for (int j = 0; j < E; ++j) E_transposed[j].add(J.J_leaf[i * E + j], x);
      }
    });
    const double* Z_k = J.anchors.Z + k * E * K;
    double E_t[E * K];
    for (int j = 0; j < E; ++j) {
      Z[j] = Row<K>::load(Z_k + j * K);
      E_transposed[j].store(E_t + j * K);
    }
    for (int j = 0; j < E; ++j) {
      for (int m = 0; m < E; ++m) E_transposed[j].add(C[j * E + m], Z[m]);
    }
    for (int i = 0; i < K; ++i) {
      for (int j = 0; j < E; ++j) {
        B[i].add(E_t[j * K + i], Z[j]);
        B[i].add(Z_k[j * K + i], E_transposed[j]);
      }
    }
  }
};

template <int R, int HubSize, int LeafSize, bool anchored>
constexpr BlockKernels make_block_kernels() {
  using Kernels = Blocks<R, HubSize, LeafSize, anchored>;
  return {&Kernels::multiply, &Kernels::transpose_multiply_hubs,
          &Kernels::transpose_multiply_leaves, &Kernels::normal_blocks_hubs,
          &Kernels::normal_blocks_leaves};
}

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
