// The matrix is cut into square tiles. The task of tile (I, J), I >= J, copies it from A into
// packed storage, subtracts the products of the tiles left of it in rows I and J, then factorises
// it (I = J) or divides by the diagonal tile (J, J), and copies it back. Tasks are started column
// by column; each waits for the tiles it needs, all of which were started before, so there are no
// barriers between columns. How the sums are ordered is told in dense_kernels.h.

#include <raybundle/linalg/dense_cholesky.h>

#include <algorithm>
#include <cstddef>
#include <limits>
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
/// Columns multiplied at a time: eight rows of so many columns stay in the first-level cache.
constexpr std::int64_t slice_columns = 240;

const DenseKernels* kernels_for(InstructionSet set) {
  const DenseKernels* found = nullptr;
  if (set == InstructionSet::avx512) found = dense_kernels_avx512();
  if (found == nullptr && set >= InstructionSet::avx2) found = dense_kernels_avx2();
  return found != nullptr ? found : dense_kernels_baseline();
}

std::int64_t ceil_div(std::int64_t a, std::int64_t b) { return (a + b - 1) / b; }

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

DenseCholesky::AlignedArray DenseCholesky::allocate(std::int64_t count) {
  const std::size_t bytes = static_cast<std::size_t>(count) * sizeof(double);
  return AlignedArray(static_cast<double*>(::operator new(bytes, alignment)));
}

DenseCholesky::DenseCholesky(std::int64_t order, InstructionSet set)
    : order_(order), kernels_(kernels_for(set)), strips_(ceil_div(order, kernels_->strip)) {
  const std::int64_t strip = kernels_->strip;
  const std::int64_t padded = strips_ * strip;
  packed_ = allocate(strip * strip / 2 * strips_ * (strips_ + 1));
  inverse_diagonal_ = allocate(padded);
  threshold_ = allocate(padded);
  triangle_ = {order_, packed_.get(), inverse_diagonal_.get(), threshold_.get()};
  finished_ = std::make_unique<std::atomic<std::int64_t>[]>(static_cast<std::size_t>(strips_));
}

bool DenseCholesky::factor(double* A, std::int64_t ld, ThreadPool& pool) {
  if (order_ == 0) return true;
  set_thresholds(A, ld);
  tile_strips_ = choose_tile(order_, kernels_->strip, pool.threads());
  const std::int64_t tiles = ceil_div(strips_, tile_strips_);
  std::for_each_n(finished_.get(), tiles, [](auto& n) { n.store(0, std::memory_order_relaxed); });
  failed_.store(false, std::memory_order_relaxed);
  pool.run(tiles * (tiles + 1) / 2, [&](std::int64_t index) {
    const Tile tile = tile_at(index, tiles);
    factor_tile(A, ld, tile.row, tile.column);
  });
  return !failed_.load(std::memory_order_relaxed);
}

void DenseCholesky::solve(const double* A, std::int64_t ld, double* b) const {
  kernels_->forward(order_, A, ld, b);
  kernels_->backward(order_, A, ld, b);
}

void DenseCholesky::set_thresholds(const double* A, std::int64_t ld) {
  const double tolerance = static_cast<double>(order_) * std::numeric_limits<double>::epsilon();
  for (std::int64_t k = 0; k < order_; ++k)
    threshold_[static_cast<std::size_t>(k)] = tolerance * A[k * ld + k];
  for (std::int64_t k = order_; k < strips_ * kernels_->strip; ++k)
    threshold_[static_cast<std::size_t>(k)] = 0.0;
}

StripRange DenseCholesky::strips_of_tile(std::int64_t tile) const {
  return {tile * tile_strips_, std::min((tile + 1) * tile_strips_, strips_)};
}

void DenseCholesky::factor_tile(double* A, std::int64_t ld, std::int64_t row, std::int64_t column) {
  // After a failure the remaining tasks only count, so that nobody waits for ever.
  if (!failed_.load(std::memory_order_relaxed)) {
    const StripRange rows = strips_of_tile(row);
    const StripRange columns = strips_of_tile(column);
    kernels_->pack(A, ld, triangle_, rows, columns);
    if (compute_tile(row, column)) {
      kernels_->unpack(triangle_, A, ld, rows, columns);
    } else {
      failed_.store(true, std::memory_order_relaxed);
    }
  }
  finished_[static_cast<std::size_t>(row)].store(column + 1, std::memory_order_release);
}

bool DenseCholesky::compute_tile(std::int64_t row, std::int64_t column) {
  const StripRange rows = strips_of_tile(row);
  const StripRange columns = strips_of_tile(column);
  const auto& finished_in_row = finished_[static_cast<std::size_t>(row)];
  const auto& finished_in_column = finished_[static_cast<std::size_t>(column)];
  wait_until(finished_in_row, column);
  wait_until(finished_in_column, column);
  const std::int64_t slice = slice_columns / kernels_->strip;
  std::int64_t from = 0;
  for (; from + slice < columns.begin; from += slice) {
    kernels_->update(triangle_, rows, columns, {from, from + slice});
  }
  if (row == column) return kernels_->factor(triangle_, columns, from);

  if (finished_in_column.load(std::memory_order_acquire) <= column) {
    kernels_->update(triangle_, rows, columns, {from, columns.begin});
    from = columns.begin;
    wait_until(finished_in_column, column + 1);
  }
  if (!failed_.load(std::memory_order_relaxed)) kernels_->solve(triangle_, rows, columns, from);
  return true;
}

}  // namespace raybundle::linalg
