#pragma once

#include <raybundle/linalg/symmetric_blocks.h>

#include <vector>

namespace raybundle::linalg {

/// The columns of a Cholesky factor in groups that share their sparsity below, and the tree by
/// which they depend on one another: a supernode comes after all of its children, and their rows
/// below are among its own rows and its rows below.
struct Supernodes {
  std::vector<std::int32_t> order;      ///< blocks as they are eliminated; place k is order[k]
  std::vector<std::int32_t> place;      ///< of a block: the inverse
  std::vector<std::int64_t> offset;     ///< scalars before place k, and the order of the matrix
  std::vector<std::int32_t> first;      ///< supernode s has places first[s] .. first[s + 1]
  std::vector<std::int32_t> parent;     ///< -1: none
  std::vector<std::int64_t> row_begin;  ///< rows below of supernode s: row[row_begin[s]] ...
  std::vector<std::int32_t> row;        ///< places, ascending

  std::int32_t count() const { return static_cast<std::int32_t>(parent.size()); }
  /// Scalar columns, and scalar rows below.
  std::int64_t width(std::int32_t s) const;
  std::int64_t height(std::int32_t s) const;
};

/// From an order of the blocks, to be changed only within what gives the same sparsity. Groups of
/// almost the same sparsity are merged, with zeros stored for it, where that is predicted to take
/// less time; supernodes with much to keep come first among their siblings.
Supernodes find_supernodes(const SymmetricPattern& pattern,
                           const std::vector<std::int64_t>& permutation);

/// Predicted multiplications of a factorisation, as fast as dense ones; what waits for memory
/// counts for more than it has. By the layout of AVX-512 on every machine.
double front_work(double width, double height);
double factor_work(const Supernodes& supernodes);

}  // namespace raybundle::linalg
