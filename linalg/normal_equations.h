#pragma once

#include <raybundle/linalg/block_jacobian.h>
#include <raybundle/linalg/hub_sums.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace raybundle::linalg {

/// The gradient, the diagonal and blocks of H = J^T J [Qu18, Eq. 3.42-3.47]. E is left in the
/// Jacobian, and so are the blocks of hubs, which few methods need.
struct NormalEquations {
  explicit NormalEquations(const BlockLayout& layout);
  static double memory(const LayoutSize& n);

  /// All of it, from rows that are stored into J on the way, tile by tile: `evaluate(tile)` writes
  /// the rows of a tile and returns a number, such as their cost; returns the sum of these. Whole
  /// leaves make a tile, or a part of a leaf with more rows than a tile has. Z of J's anchors must
  /// be there when the last row of its leaf is.
  template <class Evaluate>
  double form(BlockJacobian& J, ThreadPool& pool, Evaluate&& evaluate) {
    std::array<double, max_chunks> partial = {};
    const std::int64_t numbers = std::int64_t{layout->hub_size} * sums_of_hub(layout->anchored());
    const double* sums =
        sums_.form(*layout, numbers, pool,
                   [&](std::int64_t first, std::int64_t last, std::int64_t piece, double* of_hubs) {
                     partial[index(piece)] = absorb(J, first, last, of_hubs, evaluate);
                   });
    collect(sums);
    return std::accumulate(partial.begin(), partial.end(), 0.0);
  }

  /// The diagonal blocks of H of a side, anchors included; those of hubs are computed here.
  void diagonal_blocks(const BlockJacobian& J, Side side, std::vector<double>& H,
                       ThreadPool& pool) const;

  /// J_hub^T r.
  const double* own_hub_gradient() const {
    return layout->anchored() ? own_gradient_.data() : gradient.data();
  }

  double diagonal_entry(std::int64_t i) const;  ///< H_ii of any unknown
  /// Writes diag(H), clamped to [low, high], to d (all unknowns).
  void diagonal(double low, double high, double* d, ThreadPool& pool) const;

  /// g^T diag(H)^-1 g over those of the first `unknowns` that have a diagonal.
  double scaled_gradient_squares(std::int64_t unknowns, ThreadPool& pool) const;

  const BlockLayout* layout;     ///< outlives this
  LargeVector<double> C;         ///< leaves x (leaf_size x leaf_size), symmetric
  LargeVector<double> gradient;  ///< J^T r: hubs, then leaves

 private:
  /// The first leaf that is not wholly in the tile which starts with a row of `leaf`, and the last
  /// row of that tile.
  struct TileEnd {
    std::int64_t leaf;
    std::int64_t row;
  };
  TileEnd tile_end(std::int64_t row, std::int64_t leaf, std::int64_t last_leaf) const;
  template <class Evaluate>
  double absorb(BlockJacobian& J, std::int64_t first, std::int64_t last, double* of_hubs,
                Evaluate&& evaluate);
  void collect(const double* sums_of_hubs);

  HubSums sums_;
  std::vector<double> hub_diagonal_;
  std::vector<double> own_gradient_;  // empty without anchors
};

// The rows of leaves [first, last), by tiles in scratch that the first-level cache holds.
template <class Evaluate>
double NormalEquations::absorb(BlockJacobian& J, std::int64_t first, std::int64_t last,
                               double* of_hubs, Evaluate&& evaluate) {
  constexpr std::int64_t most_numbers = tile_rows * 30;  // of any shape: residuals and both blocks
  std::array<double, index(most_numbers)> scratch;
  const NormalView normal = {C.data(), gradient.data() + layout->offset(Side::leaves), of_hubs};
  const std::int64_t of_residuals = tile_rows * layout->row_size;
  const std::int64_t row = layout->leaf_rows()[index(first)];
  RowTile tile = {row, row, scratch.data(), scratch.data() + of_residuals,
                  scratch.data() + of_residuals * (1 + layout->hub_size)};
  double sum = 0;
  for (std::int64_t leaf = first; leaf < last;) {
    const TileEnd end = tile_end(tile.last, leaf, last);
    tile.first = tile.last;
    tile.last = end.row;
    if (tile.first < tile.last) sum += evaluate(tile);
    block_kernels(J).absorb(J.view(), tile, leaf, std::max(end.leaf, leaf + 1), normal);
    leaf = end.leaf;
  }
  return sum;
}

}  // namespace raybundle::linalg
