// The kernels of kernel_table.h as plain loops with fixed trip counts. Included once per
// instruction set by a unit that defines RAYBUNDLE_ISA and is compiled for it; everything is local
// to that unit and nothing of the standard library is used, so that no code compiled for one
// instruction set can be linked in place of another's.
//
// R residuals per row, K unknowns per kept block, E per eliminated block, W per block of a side.

#include <raybundle/linalg/kernels/row_shapes_impl.h>

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

// One side of the Jacobian; `Parts` tells what rows have of its blocks.
template <int R, int W, class Parts>
struct SideKernels {
  static void transpose_multiply(const SideView& side, const double* J, const double* u,
                                 Index first, Index last, double* y) {
    for (Index b = first; b < last; ++b) {
      Row<W> sum = {};
      Parts::template each<R * W>(side, b, J, [&](Index part, Index row, Index) {
        for (int k = 0; k < R; ++k) {
          sum.add(u[row * R + k], Row<W>::load(J + (part * R + k) * W));
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
      Parts::template each<R * W>(side, b, J, [&](Index part, Index row, Index) {
        for (int k = 0; k < R; ++k) {
          const double* J_row = J + (part * R + k) * W;
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

// u += J x of one row, by its parts on the kept side.
template <int R, int K, class Rows>
[[gnu::always_inline]] inline void add_row_product(const SideView& kept, Index row, Index c,
                                                   const double* J, const double* x, double* u) {
  Rows::parts_of_row(kept, row, c, [&](Index part, Index block) {
    add_product<R, K>(J + part * R * K, x + block * K, u);
  });
}

template <int R, int K, int E, class Rows>
struct RowKernels {
  // K unknowns per hub, E per leaf.
  static void multiply(const SideView& leaves, const SideView& hubs, const double* J_hub,
                       const double* J_leaf, const double* x_hub, const double* x_leaf, Index first,
                       Index last, double* u) {
    for (Index b = first; b < last; ++b) {
      Rows::rows(leaves, b, [&](Index row, Index c) {
        double sum[R] = {};
        add_row_product<R, K, Rows>(hubs, row, c, J_hub, x_hub, sum);
        add_product<R, E>(J_leaf + row * R * E, x_leaf + b * E, sum);
        for (int k = 0; k < R; ++k) u[row * R + k] = sum[k];
      });
    }
  }
};

template <int R, int HubSize, int LeafSize, class Rows>
constexpr BlockKernels make_block_kernels() {
  using Hubs = SideKernels<R, HubSize, PartsOfHub<Rows>>;
  using Leaves = SideKernels<R, LeafSize, PartsOfLeaf<Rows>>;
  return {&RowKernels<R, HubSize, LeafSize, Rows>::multiply, &Hubs::transpose_multiply,
          &Leaves::transpose_multiply, &Hubs::normal_blocks, &Leaves::normal_blocks};
}

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
