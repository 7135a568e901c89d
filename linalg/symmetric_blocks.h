#pragma once

#include <raybundle/linalg/block_layout.h>
#include <raybundle/linalg/large_vector.h>

#include <vector>

namespace raybundle::linalg {

/// Sparsity of a symmetric block matrix: for each block row a its blocks b >= a, ascending, the
/// diagonal block first.
struct SymmetricPattern {
  std::vector<std::int64_t> offset;  ///< scalar offset of each block, and the order at the end
  std::vector<std::int64_t> row_begin;
  std::vector<std::int32_t> column;

  std::int64_t blocks() const { return static_cast<std::int64_t>(offset.size()) - 1; }
  std::int64_t order() const { return offset.back(); }
  std::int64_t block_size(std::int64_t a) const { return offset[index(a + 1)] - offset[index(a)]; }
  std::int64_t scalar_nonzeros() const;  ///< stored numbers: the upper block triangle
};

/// The values of such a matrix, in one of two storages. Read as columns instead of rows, both are
/// the lower triangle of a column-major matrix, which is what a Cholesky factorisation takes:
/// dense storage is order x order; in sparse storage the scalar rows of a block row follow one
/// another, each as long as the row has columns (compressed columns without further copying). The
/// entries above the diagonal inside a diagonal block are stored and ignored.
class SymmetricBlocks {
 public:
  enum class Storage { dense, sparse };

  SymmetricBlocks(SymmetricPattern pattern, Storage storage);

  const SymmetricPattern& pattern() const { return pattern_; }
  Storage storage() const { return storage_; }
  double* values() { return values_.data(); }
  const double* values() const { return values_.data(); }
  std::int64_t value_count() const { return static_cast<std::int64_t>(values_.size()); }

  /// First number of block row a, and the distance between its scalar rows.
  double* row(std::int64_t a) { return values_.data() + row_value_[index(a)]; }
  const double* row(std::int64_t a) const { return values_.data() + row_value_[index(a)]; }
  std::int64_t stride(std::int64_t a) const;
  /// Distance from the start of a scalar row to the block at position p of the pattern.
  std::int64_t block_shift(std::int64_t p) const { return shift_[index(p)]; }

  void set_zero(std::int64_t a);  ///< clears block row a

 private:
  SymmetricPattern pattern_;
  Storage storage_;
  std::vector<std::int64_t> row_value_;
  std::vector<std::int64_t> shift_;  // sparse: of each block within its scalar row
  LargeVector<double> values_;
};

}  // namespace raybundle::linalg
