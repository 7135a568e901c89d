// How kernels walk over rows and couplings. Included by the kernel units only.

#pragma once

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

// Asks for the rows `ahead` places further on of an array that is gone through in order: reads
// across pages come too late by themselves.
template <int numbers>
inline void prefetch_ahead(const double* row) {
  constexpr int ahead = 48;
  prefetch<8 * numbers>(row + ahead * numbers);
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

// The same where J has `size` numbers a row, which are asked for ahead.
template <int size, class Visit>
[[gnu::always_inline]] inline void for_rows_ahead(const SideView& side, Index b, const double* J,
                                                  Visit&& visit) {
  for (Index p = side.begin[b]; p < side.begin[b + 1]; ++p) {
    const Index ahead = coupling_ahead(side, b, p);
    if (ahead >= 0) prefetch<size * 8>(J + row_begin(side, ahead) * size);
    const Index c = coupling(side, p);
    if (!side.list) prefetch_ahead<size>(J + row_begin(side, c) * size);
    for_rows_of(side, c, [&](Index row) { visit(row, c); });
  }
}

// z += Z x over the anchors of a leaf; `hub_of` tells the hub of a coupling.
template <int K, int E>
[[gnu::always_inline]] inline void add_anchored(const AnchorView& anchors, Index leaf,
                                                const std::int32_t* hub_of, const double* x_hub,
                                                double* z) {
  for (Index k = anchors.begin[leaf]; k < anchors.begin[leaf + 1]; ++k) {
    const double* x = x_hub + Index{hub_of[anchors.coupling[k]]} * K;
    for (int i = 0; i < E; ++i) z[i] += Row<K>::dot(anchors.Z + (k * E + i) * K, x);
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
