// How kernels walk over rows and couplings. Included by the kernel units only.

#pragma once

#include <raybundle/linalg/kernels/row_block.h>

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
inline void prefetch(const void* x) {
  for (int at = 0; at < bytes; at += 64) __builtin_prefetch(static_cast<const char*>(x) + at);
}

// Asks for what an array that is gone through in order has `ahead` places of `size` bytes further
// on: reads across pages come too late by themselves.
template <int size>
inline void prefetch_ahead(const void* x) {
  constexpr int ahead = 48;
  prefetch<size>(static_cast<const char*>(x) + ahead * size);
}
template <class T, int R, int N>
inline void prefetch_ahead(const RowBlock<T, R, N>& J) {
  prefetch_ahead<static_cast<int>(sizeof(T)) * R * N>(J.values);
}

// How many couplings ahead of their use scattered blocks are asked for.
constexpr Index lookahead = 8;

// The coupling `lookahead` places after position p in a scattered list, or a negative number.
inline Index coupling_ahead(const SideView& side, Index b, Index p) {
  return side.list && p + lookahead < side.begin[b + 1] ? side.list[p + lookahead] : -1;
}

// Calls visit(coupling) for those of block b of a side.
template <class Visit>
[[gnu::always_inline]] inline void for_couplings(const SideView& side, Index b, Visit&& visit) {
  for (Index p = side.begin[b]; p < side.begin[b + 1]; ++p) visit(coupling(side, p));
}

// Calls visit(row) for those of a coupling.
template <class Visit>
[[gnu::always_inline]] inline void for_rows_of(const SideView& side, Index c, Visit&& visit) {
  for (Index row = row_begin(side, c); row < row_end(side, c); ++row) visit(row);
}

// Calls visit(row, coupling) for the rows of block b of a side.
template <class Visit>
[[gnu::always_inline]] inline void for_rows(const SideView& side, Index b, Visit&& visit) {
  for_couplings(side, b, [&](Index c) { for_rows_of(side, c, [&](Index row) { visit(row, c); }); });
}

// Calls visit(block of J, row, coupling) where blocks are `Block`s, which are asked for ahead.
template <class Block, class Visit>
[[gnu::always_inline]] inline void for_blocks_ahead(const SideView& side, Index b, const void* J,
                                                    Visit&& visit) {
  constexpr int bytes = Block::size * static_cast<int>(sizeof(*Block::of(J, 0).values));
  for (Index p = side.begin[b]; p < side.begin[b + 1]; ++p) {
    const Index ahead = coupling_ahead(side, b, p);
    if (ahead >= 0) prefetch<bytes>(Block::of(J, row_begin(side, ahead)).values);
    const Index c = coupling(side, p);
    if (!side.list) prefetch_ahead<bytes>(Block::of(J, row_begin(side, c)).values);
    for_rows_of(side, c, [&](Index row) { visit(Block::of(J, row), row, c); });
  }
}

// z += Z x over the anchors of a leaf; `hub_of` tells the hub of a coupling, x_of_hub(hub) its x.
template <int K, int E, class X>
[[gnu::always_inline]] inline void add_anchored(const AnchorView& anchors, Index leaf,
                                                const std::int32_t* hub_of, X&& x_of_hub,
                                                double* z) {
  for (Index k = anchors.begin[leaf]; k < anchors.begin[leaf + 1]; ++k) {
    const Row<K> x = x_of_hub(Index{hub_of[anchors.coupling[k]]});
    for (int i = 0; i < E; ++i) z[i] += dot(Row<K>::load(anchors.Z + (k * E + i) * K), x);
  }
}

// y += Z^T w of one anchor.
template <int K, int E>
[[gnu::always_inline]] inline void add_anchor_transposed(const AnchorView& anchors, Index k,
                                                         const double* w, Row<K>& y) {
  for (int i = 0; i < E; ++i) y.add(w[i], Row<K>::load(anchors.Z + (k * E + i) * K));
}

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
