// The triangle is cut into square tiles. The task of tile (I, J), I >= J, copies it from the matrix
// into packed storage, subtracts the products of the tiles left of it in rows I and J, then
// factorises it (I = J) or divides by the diagonal tile (J, J), and copies it back. Tasks are
// started column by column; each waits for the tiles it needs, all of which were started before, so
// there are no barriers between columns. How the sums are ordered is told in dense_kernels.h.

#include <raybundle/linalg/tiled_cholesky.h>

#include <algorithm>
#include <cstddef>
#include <thread>

namespace raybundle::linalg {
namespace {

/// Up to this order one thread works on a single tile, which fits the second-level cache.
constexpr std::int64_t single_tile_order = 512;
/// Below this order waking another thread costs more than it brings.
constexpr std::int64_t parallel_order = 160;
/// Rows of a tile: a tile and two slices of its rows share the second-level cache.
constexpr std::int64_t largest_tile = 192;
constexpr std::int64_t smallest_tile = 48;

/// Strips per tile: large tiles need fewer reads per product, small ones keep all threads busy.
std::int64_t choose_tile(std::int64_t order, std::int64_t strip, int threads) {
  const bool alone = threads == 1 || order < parallel_order;
  if (alone && order <= single_tile_order) return std::max<std::int64_t>(1, ceil_div(order, strip));
  const std::int64_t rows =
      alone ? largest_tile
            : std::clamp<std::int64_t>(order / (4 * threads), smallest_tile, largest_tile);
  return ceil_div(rows, strip);
}

struct Tile {
  std::int64_t row, column;
};

/// Tile number `index` of a lower triangle of `tiles` x `tiles`, column by column.
Tile tile_at(std::int64_t index, std::int64_t tiles) {
  std::int64_t column = 0;
  for (; index >= tiles - column; ++column) index -= tiles - column;
  return {column + index, column};
}

void wait_until(const std::atomic<std::int64_t>& counter, std::int64_t value) {
  for (int spins = 0; counter.load(std::memory_order_acquire) < value; ++spins) {
    if (spins < 2000) {
      spin_pause();
    } else {
      std::this_thread::yield();
    }
  }
}

}  // namespace

const DenseKernels& dense_kernels(InstructionSet set) {
  const DenseKernels* found = nullptr;
  if (set == InstructionSet::avx512) found = dense_kernels_avx512();
  if (found == nullptr && set >= InstructionSet::avx2) found = dense_kernels_avx2();
  return found != nullptr ? *found : *dense_kernels_baseline();
}

TiledCholesky::TiledCholesky(const DenseKernels& kernels, std::int64_t most_strips)
    : kernels_(kernels),
      finished_(
          std::make_unique<std::atomic<std::int64_t>[]>(static_cast<std::size_t>(most_strips))) {}

bool TiledCholesky::factor(const PackedTriangle& L, ThreadPool& pool, const Matrix* matrix) {
  strips_ = ceil_div(L.order, kernels_.strip);
  tile_strips_ = choose_tile(L.order, kernels_.strip, pool.threads());
  const std::int64_t tiles = ceil_div(strips_, tile_strips_);
  std::for_each_n(finished_.get(), tiles, [](auto& n) { n.store(0, std::memory_order_relaxed); });
  failed_.store(false, std::memory_order_relaxed);
  pool.run(tiles * (tiles + 1) / 2, [&](std::int64_t index) {
    const Tile tile = tile_at(index, tiles);
    factor_tile(L, matrix, tile.row, tile.column);
  });
  return !failed_.load(std::memory_order_relaxed);
}

StripRange TiledCholesky::strips_of_tile(std::int64_t tile) const {
  return {tile * tile_strips_, std::min((tile + 1) * tile_strips_, strips_)};
}

void TiledCholesky::factor_tile(const PackedTriangle& L, const Matrix* matrix, std::int64_t row,
                                std::int64_t column) {
  // After a failure the remaining tasks only count, so that nobody waits for ever.
  if (!failed_.load(std::memory_order_relaxed)) {
    const StripRange rows = strips_of_tile(row);
    const StripRange columns = strips_of_tile(column);
    if (matrix != nullptr) kernels_.pack(matrix->values, matrix->ld, L, rows, columns);
    if (!compute_tile(L, row, column)) {
      failed_.store(true, std::memory_order_relaxed);
    } else if (matrix != nullptr) {
      kernels_.unpack(L, matrix->values, matrix->ld, rows, columns);
    }
  }
  finished_[static_cast<std::size_t>(row)].store(column + 1, std::memory_order_release);
}

bool TiledCholesky::compute_tile(const PackedTriangle& L, std::int64_t row, std::int64_t column) {
  const StripRange rows = strips_of_tile(row);
  const StripRange columns = strips_of_tile(column);
  const auto& finished_in_row = finished_[static_cast<std::size_t>(row)];
  const auto& finished_in_column = finished_[static_cast<std::size_t>(column)];
  wait_until(finished_in_row, column);
  wait_until(finished_in_column, column);
  const std::int64_t slice = slice_columns / kernels_.strip;
  std::int64_t from = 0;
  for (; from + slice < columns.begin; from += slice) {
    kernels_.update(L, rows, columns, {from, from + slice});
  }
  if (row == column) return kernels_.factor(L, columns, from);

  if (finished_in_column.load(std::memory_order_acquire) <= column) {
    kernels_.update(L, rows, columns, {from, columns.begin});
    from = columns.begin;
    wait_until(finished_in_column, column + 1);
  }
  if (!failed_.load(std::memory_order_relaxed)) kernels_.solve(L, rows, columns, from);
  return true;
}

}  // namespace raybundle::linalg
