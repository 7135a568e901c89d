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

// block += x^T x.
template <int W>
[[gnu::always_inline]] inline void add_square(const double* x, Row<W>* block) {
  const auto row = Row<W>::load(x);
#pragma GCC unroll 12
  for (int i = 0; i < W; ++i) block[i].add(x[i], row);
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

  static void normal_equations(const JacobianView& J, const double* r, Index first, Index last,
                               const NormalView& normal) {
    for (Index b = first; b < last; ++b) {
      Row<E> block[E] = {}, gradient = {};
      for_rows(J.leaves, b, [&](Index row, Index c) {
        double* of_hub = normal.of_hubs + Index{J.hubs.block[c]} * K * sums_of_hub(anchored);
        auto diagonal = Row<K>::load(of_hub), own = Row<K>::load(of_hub + K);
        for (Index k = row * R; k < (row + 1) * R; ++k) {
          add_square<E>(J.J_leaf + k * E, block);
          gradient.add(r[k], Row<E>::load(J.J_leaf + k * E));
          const auto x = Row<K>::load(J.J_hub + k * K);
          diagonal.add_products(x, x);
          own.add(r[k], x);
        }
        diagonal.store(of_hub);
        own.store(of_hub + K);
      });
      store_block<E>(block, normal.C + b * E * E);
      gradient.store(normal.g_leaf + b * E);
      if constexpr (anchored) {
        for (Index k = J.anchors.begin[b]; k < J.anchors.begin[b + 1]; ++k) {
          add_anchor(J, k, normal.C + b * E * E, normal.g_leaf + b * E, normal.of_hubs);
        }
      }
    }
  }

  // F = J_leaf^T J_hub + 1/2 C Z of an anchor, by which it adds F^T Z + Z^T F to the block of J^T J
  // of its hub.
  [[gnu::always_inline]] static void anchor_product(const JacobianView& J, Index k, const double* C,
                                                    Row<K>* F) {
    for_rows_of(J.leaves, J.anchors.coupling[k], [&](Index row) {
      for (Index i = row * R; i < (row + 1) * R; ++i) {
        const auto x = Row<K>::load(J.J_hub + i * K);
        for (int j = 0; j < E; ++j) F[j].add(J.J_leaf[i * E + j], x);
      }
    });
    for (int m = 0; m < E; ++m) {
      const auto Z = Row<K>::load(J.anchors.Z + (k * E + m) * K);
      for (int j = 0; j < E; ++j) F[j].add(0.5 * C[j * E + m], Z);
    }
  }

  // What an anchor adds to the diagonal of its hub, and to its gradient: Z^T g.
  [[gnu::always_inline]] static void add_anchor(const JacobianView& J, Index k, const double* C,
                                                const double* g, double* of_hubs) {
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

  static void hub_squares(const JacobianView& J, const double* C, Index first, Index last,
                          double* H) {
    for (Index b = first; b < last; ++b) {
      Row<K> block[K] = {};
      for_rows_ahead<R * K>(J.hubs, b, J.J_hub, [&](Index row, Index) {
        for (Index k = row * R; k < (row + 1) * R; ++k) add_square<K>(J.J_hub + k * K, block);
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

template <int R, int HubSize, int LeafSize, bool anchored>
constexpr BlockKernels make_block_kernels() {
  using Kernels = Blocks<R, HubSize, LeafSize, anchored>;
  return {&Kernels::multiply, &Kernels::transpose_multiply_hubs,
          &Kernels::transpose_multiply_leaves, &Kernels::normal_equations, &Kernels::hub_squares};
}

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
