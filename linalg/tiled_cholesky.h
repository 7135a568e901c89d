#pragma once

#include <raybundle/linalg/kernels/dense_kernels.h>
#include <raybundle/linalg/parallel.h>

#include <atomic>
#include <cstdint>
#include <memory>

namespace raybundle::linalg {

/// The kernels of a set, or of the next lower one that the library was built for.
const DenseKernels& dense_kernels(InstructionSet set);

/// Factorises packed triangles in parallel by tiles; the same bits for any number of threads.
class TiledCholesky {
 public:
  /// Where a triangle is copied from and back to, tile by tile: column-major, `ld` between columns.
  struct Matrix {
    double* values;
    std::int64_t ld;
  };

  /// For triangles of at most so many strips.
  TiledCholesky(const DenseKernels& kernels, std::int64_t most_strips);

  /// False when a pivot fails (PackedTriangle::threshold). Without a matrix the triangle holds what
  /// is to be factorised already.
  bool factor(const PackedTriangle& L, ThreadPool& pool, const Matrix* matrix = nullptr);

 private:
  StripRange strips_of_tile(std::int64_t tile) const;
  void factor_tile(const PackedTriangle& L, const Matrix* matrix, std::int64_t row,
                   std::int64_t column);
  bool compute_tile(const PackedTriangle& L, std::int64_t row, std::int64_t column);

  const DenseKernels& kernels_;
  std::int64_t strips_ = 0;                                ///< of the triangle at work
  std::int64_t tile_strips_ = 1;                           ///< strips per tile of it
  std::unique_ptr<std::atomic<std::int64_t>[]> finished_;  ///< tiles finished in each row of tiles
  std::atomic<bool> failed_{false};
};

}  // namespace raybundle::linalg
