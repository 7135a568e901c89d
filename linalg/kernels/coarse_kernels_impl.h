// What the rows of eliminated blocks add to the matrix of a coarse space; see CoarseView in
// kernel_table.h. R residuals per row, K unknowns per kept block, E per eliminated block, N = K + 1
// modes per cluster.
//
// For an eliminated block and a cluster g of kept blocks, with sums over the rows of g and the
// anchors in g,
//   T_g = sum (J_k P)^T J_e - sum (Z P)^T D,   V_g = T_g M,
//   A_gh += [g = h] sum (J_k P)^T J_k P + (Z P)_g^T D (Z P)_h - V_g V_h^T.

#pragma once

#include <raybundle/linalg/kernels/coupling_products_impl.h>

namespace raybundle::linalg::RAYBUNDLE_ISA {
namespace {

template <class T, int R, int K, int E, bool anchored>
struct Coarse {
  static constexpr int N = K + 1;
  static constexpr int per_cluster = coarse_numbers(K, E);

  // x^T P of one block.
  [[gnu::always_inline]] static Row<N> project(const double* x, const double* P) {
    Row<N> sum = {};
    for (int i = 0; i < K; ++i) sum.add(x[i], Row<N>::load(P + i * N));
    return sum;
  }

  // Where block (g, h) of the pattern, g <= h, has its values.
  static double* block(const CoarseView& coarse, std::int32_t g, std::int32_t h, double* values) {
    Index low = coarse.row_begin[g], high = coarse.row_begin[g + 1];
    while (high - low > 1) {
      const Index middle = (low + high) / 2;
      (coarse.column[middle] <= h ? low : high) = middle;
    }
    return values + low * N * N;
  }

  // The numbers of a cluster for the block at hand: T, then Z P; cleared when it is met first.
  static double* enter(const CoarseView& coarse, std::int32_t cluster, Index& count) {
    std::int32_t& place = coarse.place[cluster];
    double* numbers = coarse.numbers + Index{place} * per_cluster;
    if (place >= 0) return numbers;
    place = static_cast<std::int32_t>(count);
    coarse.found[count] = cluster;
    numbers = coarse.numbers + count * per_cluster;
    ++count;
    clear<per_cluster>(numbers);
    return numbers;
  }

  [[gnu::always_inline]] static void add_row(const EliminationView& view, const CoarseView& coarse,
                                             Index row, std::int32_t hub, double* of_cluster,
                                             double* diagonal) {
    Row<K> kept[R];
    Row<E> eliminated[R];
    RowBlock<T, R, K>::of(view.J_kept, row).residuals(kept);
    RowBlock<T, R, E>::of(view.J_eliminated, row).residuals(eliminated);
    Row<N> JP[R];
    double left[R * N];
    for (int r = 0; r < R; ++r) {
      double J[K];
      kept[r].store(J);
      JP[r] = project(J, coarse.P + Index{hub} * K * N);
      JP[r].store(left + r * N);
      for (int k = 0; k < E; ++k) {
        auto sum = Row<N>::load(of_cluster + k * N);
        sum.add(eliminated[r][k], JP[r]);
        sum.store(of_cluster + k * N);
      }
    }
    Square<N>{diagonal, N}.template add<R>(left, JP);
  }

  static void add_anchors(const EliminationView& view, const CoarseView& coarse, Index e,
                          Index& count) {
    for (Index k = view.anchors.begin[e]; k < view.anchors.begin[e + 1]; ++k) {
      const std::int32_t hub = view.kept.block[view.anchors.coupling[k]];
      double* of_cluster = enter(coarse, coarse.cluster[hub], count);
      for (int i = 0; i < E; ++i) {
        const Row<N> ZP = project(view.anchors.Z + (k * E + i) * K, coarse.P + Index{hub} * K * N);
        auto of_T = Row<N>::load(of_cluster + i * N);
        auto of_Z = Row<N>::load(of_cluster + (E + i) * N);
        of_T.add(-view.D[e * E + i], ZP);
        of_Z.add(1, ZP);
        of_T.store(of_cluster + i * N);
        of_Z.store(of_cluster + (E + i) * N);
      }
    }
  }

  // T := V, in place.
  [[gnu::always_inline]] static void transform(const double* M, double* of_cluster) {
    Row<N> V[E] = {};
    for (int k = 0; k < E; ++k) {
      const auto T_k = Row<N>::load(of_cluster + k * N);
      for (int i = 0; i < E; ++i) V[i].add(M[k * E + i], T_k);
    }
    for (int i = 0; i < E; ++i) V[i].store(of_cluster + i * N);
  }

  [[gnu::always_inline]] static void add_pair(const EliminationView& view, Index e,
                                              const double* left, const double* right,
                                              double* values) {
    const Square<N> A = {values, N};
    Row<N> scaled[E] = {};
    for (int k = 0; k < E; ++k) scaled[k].add(-1, Row<N>::load(right + k * N));
    A.template add<E>(left, scaled);
    if constexpr (anchored) {
      for (int k = 0; k < E; ++k) {
        scaled[k] = {};
        scaled[k].add(view.D[e * E + k], Row<N>::load(right + (E + k) * N));
      }
      A.template add<E>(left + E * N, scaled);
    }
  }

  static void add_products(const EliminationView& view, const CoarseView& coarse, Index first,
                           Index last, double* values) {
    for (Index e = first; e < last; ++e) {
      Index count = 0;
      for_rows(view.eliminated, e, [&](Index row, Index c) {
        prefetch_ahead(RowBlock<T, R, K>::of(view.J_kept, row));
        const std::int32_t hub = view.kept.block[c], cluster = coarse.cluster[hub];
        double* diagonal = values + coarse.row_begin[cluster] * N * N;
        add_row(view, coarse, row, hub, enter(coarse, cluster, count), diagonal);
      });
      if constexpr (anchored) add_anchors(view, coarse, e, count);
      for (Index i = 0; i < count; ++i) {
        transform(view.M + e * E * E, coarse.numbers + i * per_cluster);
        coarse.place[coarse.found[i]] = -1;
      }
      for (Index i = 0; i < count; ++i) {
        for (Index j = i; j < count; ++j) {
          const bool in_order = coarse.found[i] <= coarse.found[j];
          const Index g = in_order ? i : j, h = in_order ? j : i;
          add_pair(view, e, coarse.numbers + g * per_cluster, coarse.numbers + h * per_cluster,
                   block(coarse, coarse.found[g], coarse.found[h], values));
        }
      }
    }
  }
};

template <class T, int R, int K, int E, bool anchored>
constexpr decltype(EliminationKernels::coarse_products) coarse_products() {
  if constexpr (K > E) return &Coarse<T, R, K, E, anchored>::add_products;
  return nullptr;
}

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
