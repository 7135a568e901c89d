// The kernels of kernel_table.h as plain loops with fixed trip counts. Included once per
// instruction set by a unit that defines RAYBUNDLE_ISA and is compiled for it; everything is local
// to that unit and nothing of the standard library is used, so that no code compiled for one
// instruction set can be linked in place of another's.
//
// R residuals per row, K unknowns per kept block, E per eliminated block, W per block of a side.

#include <raybundle/linalg/kernels/kernel_table.h>
#include <raybundle/linalg/kernels/row.h>

namespace raybundle::linalg::RAYBUNDLE_ISA {
namespace {

using Index = std::int64_t;

inline Index coupling(const SideView& side, Index p) { return side.list ? side.list[p] : p; }
inline Index position(const SideView& side, Index c) {
  return side.position ? side.position[c] : c;
}
inline Index row_begin(const SideView& side, Index c) { return side.rows ? side.rows[c] : c; }
inline Index row_end(const SideView& side, Index c) { return side.rows ? side.rows[c + 1] : c + 1; }

// Asks for `bytes` at x before they are needed.
template <int bytes>
inline void prefetch(const double* x) {
  for (int at = 0; at < bytes; at += 64) {
    __builtin_prefetch(reinterpret_cast<const char*>(x) + at);
  }
}

// How many couplings ahead of their use scattered blocks are asked for.
constexpr Index lookahead = 8;

// The coupling `lookahead` places after position p in a scattered list, or a negative number.
inline Index coupling_ahead(const SideView& side, Index b, Index p) {
  return side.list && p + lookahead < side.begin[b + 1] ? side.list[p + lookahead] : -1;
}

// Calls visit(position, coupling, row) for every row of block b.
template <class Visit>
inline void for_rows(const SideView& side, Index b, Visit&& visit) {
  for (Index p = side.begin[b]; p < side.begin[b + 1]; ++p) {
    const Index c = coupling(side, p);
    for (Index row = row_begin(side, c); row < row_end(side, c); ++row) visit(p, c, row);
  }
}

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

template <int R, int W>
struct SideKernels {
  static void prefetch_row(const SideView& side, Index b, Index p, const double* J) {
    const Index ahead = coupling_ahead(side, b, p);
    if (ahead >= 0) prefetch<R * W * 8>(J + row_begin(side, ahead) * R * W);
  }

  static void transpose_multiply(const SideView& side, const double* J, const double* u,
                                 Index first, Index last, double* y) {
    for (Index b = first; b < last; ++b) {
      Row<W> sum = {};
      for_rows(side, b, [&](Index p, Index, Index row) {
        prefetch_row(side, b, p, J);
        for (int k = 0; k < R; ++k) {
          sum.add(u[row * R + k], Row<W>::load(J + (row * R + k) * W));
        }
      });
      sum.store(y + b * W);
    }
  }

  static void normal_blocks(const SideView& side, const double* J, const double* r, Index first,
                            Index last, double* H, double* g) {
    for (Index b = first; b < last; ++b) {
      Row<W> block[W] = {};
      Row<W> sum = {};
      for_rows(side, b, [&](Index p, Index, Index row) {
        prefetch_row(side, b, p, J);
        for (int k = 0; k < R; ++k) {
          const double* J_row = J + (row * R + k) * W;
          const auto x = Row<W>::load(J_row);
#pragma GCC unroll 12
          for (int i = 0; i < W; ++i) block[i].add(J_row[i], x);
          sum.add(r[row * R + k], x);
        }
      });
      for (int i = 0; i < W; ++i) block[i].store(H + (b * W + i) * W);
      sum.store(g + b * W);
    }
  }
};

template <int R, int K, int E>
struct RowKernels {
  // K unknowns per hub, E per leaf.
  static void multiply(const SideView& leaves, const SideView& hubs, const double* J_hub,
                       const double* J_leaf, const double* x_hub, const double* x_leaf, Index first,
                       Index last, double* u) {
    for (Index b = first; b < last; ++b) {
      for_rows(leaves, b, [&](Index, Index c, Index row) {
        double sum[R] = {};
        add_product<R, K>(J_hub + row * R * K, x_hub + hubs.block[c] * K, sum);
        add_product<R, E>(J_leaf + row * R * E, x_leaf + b * E, sum);
        for (int k = 0; k < R; ++k) u[row * R + k] = sum[k];
      });
    }
  }
};

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

template <int R, int K, int E>
struct Eliminate {
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
                        Index last, double* U, double* y) {
    for (Index e = first; e < last; ++e) {
      const double* M = view.M + e * E * E;
      clear<E>(y + e * E);
      add_transpose_product<E, E>(M, g_eliminated + e * E, y + e * E);
      for_rows(view.eliminated, e, [&](Index, Index, Index row) {
        for (Index k = row * R; k < (row + 1) * R; ++k) {
          clear<E>(U + k * E);
          add_transpose_product<E, E>(M, view.J_eliminated + k * E, U + k * E);
        }
      });
    }
  }

  // v -= J^T U y of one row.
  static void reduce_row(const EliminationView& view, Index e, Index row, Row<K>& v) {
    for (Index k = row * R; k < (row + 1) * R; ++k) {
      v.add(-Row<E>::dot(view.U + k * E, view.y + e * E), Row<K>::load(view.J_kept + k * K));
    }
  }

  static void reduce_gradient(const EliminationView& view, Index first, Index last, double* v) {
    for (Index a = first; a < last; ++a) {
      auto reduced = Row<K>::load(v + a * K);
      for_rows(view.kept, a, [&](Index, Index c, Index row) {
        reduce_row(view, view.eliminated.block[c], row, reduced);
      });
      reduced.store(v + a * K);
    }
  }

  static void project(const EliminationView& view, const double* x_kept, Index first, Index last,
                      double* u) {
    for (Index e = first; e < last; ++e) {
      Row<E> t = {};
      for_rows(view.eliminated, e, [&](Index, Index c, Index row) {
        const double* x = x_kept + view.kept.block[c] * K;
        for (Index k = row * R; k < (row + 1) * R; ++k) {
          u[k] = Row<K>::dot(view.J_kept + k * K, x);
          t.add(u[k], Row<E>::load(view.U + k * E));
        }
      });
      double z[E];
      t.store(z);
      for_rows(view.eliminated, e, [&](Index, Index, Index row) {
        for (Index k = row * R; k < (row + 1) * R; ++k) u[k] -= Row<E>::dot(view.U + k * E, z);
      });
    }
  }

  static void back_substitute(const EliminationView& view, const double* x_kept, Index first,
                              Index last, double* x_eliminated) {
    for (Index e = first; e < last; ++e) {
      auto t = Row<E>::load(view.y + e * E);
      for_rows(view.eliminated, e, [&](Index, Index c, Index row) {
        const double* x = x_kept + view.kept.block[c] * K;
        for (Index k = row * R; k < (row + 1) * R; ++k) {
          t.add(Row<K>::dot(view.J_kept + k * K, x), Row<E>::load(view.U + k * E));
        }
      });
      double z[E];
      t.store(z);
      for (int i = 0; i < E; ++i) {
        x_eliminated[e * E + i] = -Row<E>::dot(view.M + (e * E + i) * E, z);
      }
    }
  }

  // A -= J_a^T U_a U_b^T J_b for one row of a and one of b.
  static void subtract_product(const EliminationView& view, Index row_a, Index row_b, double* A,
                               Index stride) {
    Row<K> right[R] = {};  // U_a U_b^T J_b
    for (int r = 0; r < R; ++r) {
      const double* U_a = view.U + (row_a * R + r) * E;
      for (int s = 0; s < R; ++s) {
        const Index k = row_b * R + s;
        right[r].add(Row<E>::dot(U_a, view.U + k * E), Row<K>::load(view.J_kept + k * K));
      }
    }
    const double* J_a = view.J_kept + row_a * R * K;
#pragma GCC unroll 12
    for (int i = 0; i < K; ++i) {
      auto sum = Row<K>::load(A + i * stride);
      for (int r = 0; r < R; ++r) sum.add(-J_a[r * K + i], right[r]);
      sum.store(A + i * stride);
    }
  }

  // The same for all rows of two couplings.
  static void subtract_products_of(const EliminationView& view, Index c, Index other, double* A,
                                   Index stride) {
    for (Index row = row_begin(view.kept, c); row < row_end(view.kept, c); ++row) {
      for (Index next = row_begin(view.kept, other); next < row_end(view.kept, other); ++next) {
        subtract_product(view, row, next, A, stride);
      }
    }
  }

  static void subtract_products(const EliminationView& view, Index a, const BlockRowView& block_row,
                                double* v) {
    auto reduced = Row<K>::load(v + a * K);
    for (Index p = view.kept.begin[a]; p < view.kept.begin[a + 1]; ++p) {
      const Index ahead = coupling_ahead(view.kept, a, p);
      if (ahead >= 0) {
        prefetch<2 * R * K * 8>(view.J_kept + row_begin(view.kept, ahead) * R * K);
        prefetch<2 * R * E * 8>(view.U + row_begin(view.kept, ahead) * R * E);
      }
      const Index c = coupling(view.kept, p);
      const Index e = view.eliminated.block[c];
      for (Index row = row_begin(view.kept, c); row < row_end(view.kept, c); ++row) {
        reduce_row(view, e, row, reduced);
      }
      for (Index q = position(view.eliminated, c); q < view.eliminated.begin[e + 1]; ++q) {
        const Index other = coupling(view.eliminated, q);
        const Index slot = block_row.slot_of[view.kept.block[other]];
        subtract_products_of(view, c, other, block_row.values + slot * K, block_row.stride);
      }
    }
    reduced.store(v + a * K);
  }

  static void diagonal_blocks(const EliminationView& view, const double* H_kept, Index first,
                              Index last, double* A_diagonal) {
    for (Index a = first; a < last; ++a) {
      double* A = A_diagonal + a * K * K;
      for (int i = 0; i < K * K; ++i) A[i] = H_kept[a * K * K + i];
      for (Index p = view.kept.begin[a]; p < view.kept.begin[a + 1]; ++p) {
        const Index c = coupling(view.kept, p);
        subtract_products_of(view, c, c, A, K);
      }
    }
  }

  static void coupling_block(const EliminationView& view, Index c, double* block, Index stride) {
    Row<E> product[K] = {};
    for (Index row = row_begin(view.kept, c); row < row_end(view.kept, c); ++row) {
      for (Index k = row * R; k < (row + 1) * R; ++k) {
        const auto J_e = Row<E>::load(view.J_eliminated + k * E);
        for (int i = 0; i < K; ++i) product[i].add(view.J_kept[k * K + i], J_e);
      }
    }
    for (int i = 0; i < K; ++i) product[i].store(block + i * stride);
  }
};

template <int R, int HubSize, int LeafSize>
constexpr BlockKernels make_block_kernels() {
  return {&RowKernels<R, HubSize, LeafSize>::multiply, &SideKernels<R, HubSize>::transpose_multiply,
          &SideKernels<R, LeafSize>::transpose_multiply, &SideKernels<R, HubSize>::normal_blocks,
          &SideKernels<R, LeafSize>::normal_blocks};
}

template <int R, int K, int E>
constexpr EliminationKernels make_elimination_kernels() {
  using Kernels = Eliminate<R, K, E>;
  return {&Kernels::factor,          &Kernels::transform,       &Kernels::reduce_gradient,
          &Kernels::project,         &Kernels::back_substitute, &Kernels::subtract_products,
          &Kernels::diagonal_blocks, &Kernels::coupling_block};
}

}  // namespace

extern const BlockKernels blocks_2_9_3 = make_block_kernels<2, 9, 3>();
extern const BlockKernels blocks_2_6_3 = make_block_kernels<2, 6, 3>();
extern const EliminationKernels eliminate_2_9_3 = make_elimination_kernels<2, 9, 3>();
extern const EliminationKernels eliminate_2_3_9 = make_elimination_kernels<2, 3, 9>();
extern const EliminationKernels eliminate_2_6_3 = make_elimination_kernels<2, 6, 3>();
extern const EliminationKernels eliminate_2_3_6 = make_elimination_kernels<2, 3, 6>();

}  // namespace raybundle::linalg::RAYBUNDLE_ISA
