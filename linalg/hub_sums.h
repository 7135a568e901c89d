#pragma once

#include <raybundle/linalg/block_layout.h>
#include <raybundle/linalg/large_vector.h>
#include <raybundle/linalg/parallel.h>

#include <algorithm>
#include <utility>

namespace raybundle::linalg {

/// Sums of some numbers for every hub over all leaves, in one pass over these: each piece of them
/// adds to a part of its own, and the parts are added in their order.
class HubSums {
 public:
  /// Calls add(first, last, piece, sums) for the pieces of the leaves, with the sums of that piece
  /// so far, hub by hub, and returns those of all; they stay until the next call.
  template <class Add>
  double* form(const BlockLayout& layout, std::int64_t numbers, ThreadPool& pool, Add&& add) {
    return form_all(layout, layout.hubs * numbers, pool, std::forward<Add>(add));
  }

  /// The same of `size` numbers, whatever they belong to.
  template <class Add>
  double* form_all(const BlockLayout& layout, std::int64_t size, ThreadPool& pool, Add&& add) {
    const std::int64_t pieces = HubSums::pieces(layout, size);
    parts_.resize(index(pieces * size));
    pool.run(pieces, [&](std::int64_t piece) {
      double* part = parts_.data() + piece * size;
      std::fill_n(part, size, 0.0);
      add(first_leaf(layout, piece, pieces), first_leaf(layout, piece + 1, pieces), piece, part);
    });
    parallel_for(pool, size, 1024, [&](std::int64_t first, std::int64_t last) {
      double* sum = parts_.data();
      for (std::int64_t k = 1; k < pieces; ++k) {
        const double* part = parts_.data() + k * size;
        for (std::int64_t i = first; i < last; ++i) sum[i] += part[i];
      }
    });
    return parts_.data();
  }

  /// Enough parts for the threads, and few beside the rows; `size` numbers each.
  static constexpr std::int64_t most_parts(std::int64_t rows, std::int64_t size) {
    constexpr std::int64_t few = 8;
    return std::clamp(rows / (2 * size + 1), few, max_chunks);
  }

  /// Bytes of the sums of some numbers per hub.
  static double memory(const LayoutSize& n, std::int64_t numbers) {
    return memory_of_all(n, n.hubs * numbers);
  }
  /// ... of `size` numbers; `n`: LayoutSize or BlockLayout.
  template <class Sizes>
  static double memory_of_all(const Sizes& n, std::int64_t size) {
    return 8 * static_cast<double>(size * pieces(n, size));
  }

 private:
  template <class Sizes>
  static std::int64_t pieces(const Sizes& n, std::int64_t size) {
    constexpr std::int64_t grain = 128;
    return std::max<std::int64_t>(chunks(n.leaves, grain, most_parts(n.rows, size)).pieces, 1);
  }

  // So that all pieces have about as many couplings: leaves differ in theirs by orders.
  static std::int64_t first_leaf(const BlockLayout& layout, std::int64_t piece,
                                 std::int64_t pieces) {
    if (piece == pieces) return layout.leaves;
    const auto& begin = layout.leaf_side.begin;
    const Chunks couplings = {layout.couplings, pieces};
    return std::lower_bound(begin.begin(), begin.end() - 1, couplings.begin(piece)) - begin.begin();
  }

  LargeVector<double> parts_;
};

}  // namespace raybundle::linalg
