// How kernels walk over rows, and over the hub parts of rows: the same loops serve rows of one
// part, where all indices coincide, and rows of several. Included by the kernel units only.
//
// OneHub also serves an elimination of hubs: "kept" are then the leaves. SeveralHubs eliminates
// leaves alone.

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

// How many couplings ahead of their use scattered blocks are asked for.
constexpr Index lookahead = 8;

// The coupling `lookahead` places after position p in a scattered list, or a negative number.
inline Index coupling_ahead(const SideView& side, Index b, Index p) {
  return side.list && p + lookahead < side.begin[b + 1] ? side.list[p + lookahead] : -1;
}

// Rows of one part: part, row and place in J are the same number.
struct OneHub {
  static constexpr bool several = false;

  // Calls visit(row, coupling) for the rows of block b of a side.
  template <class Visit>
  [[gnu::always_inline]] static void rows(const SideView& side, Index b, Visit&& visit) {
    for (Index p = side.begin[b]; p < side.begin[b + 1]; ++p) {
      const Index c = coupling(side, p);
      for (Index row = row_begin(side, c); row < row_end(side, c); ++row) visit(row, c);
    }
  }

  // Calls visit(part, kept block) for what a row, of coupling c, has on the kept side.
  template <class Visit>
  [[gnu::always_inline]] static void parts_of_row(const SideView& kept, Index row, Index c,
                                                  Visit&& visit) {
    visit(row, Index{kept.block[c]});
  }

  // Calls visit(part, row) for the parts of a coupling.
  template <class Visit>
  [[gnu::always_inline]] static void parts_of_coupling(const SideView& side, Index c,
                                                       Visit&& visit) {
    for (Index row = row_begin(side, c); row < row_end(side, c); ++row) visit(row, row);
  }
  static Index first_part(const SideView& side, Index c) { return row_begin(side, c); }
};

// Rows of any number of parts.
struct SeveralHubs {
  static constexpr bool several = true;

  template <class Visit>
  [[gnu::always_inline]] static void rows(const SideView& leaves, Index leaf, Visit&& visit) {
    const Index* begin = leaves.parts.leaf_rows + leaf;
    for (Index row = begin[0]; row < begin[1]; ++row) visit(row, Index{-1});
  }

  template <class Visit>
  [[gnu::always_inline]] static void parts_of_row(const SideView& hubs, Index row,
                                                  Index /*coupling*/, Visit&& visit) {
    const Index* begin = hubs.parts.row_parts + row;
    for (Index part = begin[0]; part < begin[1]; ++part) visit(part, Index{hubs.parts.hub[part]});
  }

  template <class Visit>
  [[gnu::always_inline]] static void parts_of_coupling(const SideView& side, Index c,
                                                       Visit&& visit) {
    const PartsView& parts = side.parts;
    for (Index k = parts.coupling_begin[c]; k < parts.coupling_begin[c + 1]; ++k) {
      visit(parts.list[k], parts.row[parts.list[k]]);
    }
  }
  static Index first_part(const SideView& side, Index c) {
    return side.parts.list[side.parts.coupling_begin[c]];
  }
};

// What rows have of a hub, or of a leaf that is kept: visit(part, row, coupling) over block b. J
// has `size` numbers a part.
template <class Rows>
struct PartsOfHub {
  template <int size, class Visit>
  [[gnu::always_inline]] static void each(const SideView& side, Index b, const double* J,
                                          Visit&& visit) {
    for (Index p = side.begin[b]; p < side.begin[b + 1]; ++p) {
      const Index ahead = coupling_ahead(side, b, p);
      if (ahead >= 0) prefetch<size * 8>(J + Rows::first_part(side, ahead) * size);
      const Index c = coupling(side, p);
      Rows::parts_of_coupling(side, c, [&](Index part, Index row) { visit(part, row, c); });
    }
  }
};

// What rows have of a leaf: all of the row.
template <class Rows>
struct PartsOfLeaf {
  template <int size, class Visit>
  [[gnu::always_inline]] static void each(const SideView& leaves, Index leaf, const double* /*J*/,
                                          Visit&& visit) {
    Rows::rows(leaves, leaf, [&](Index row, Index c) { visit(row, row, c); });
  }
};

}  // namespace
}  // namespace raybundle::linalg::RAYBUNDLE_ISA
