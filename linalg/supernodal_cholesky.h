#pragma once

#include <raybundle/linalg/front_layout.h>
#include <raybundle/linalg/large_vector.h>
#include <raybundle/linalg/tiled_cholesky.h>

#include <atomic>
#include <vector>

namespace raybundle::linalg {

/// Cholesky factorisation of sparse symmetric block matrices by dense fronts [Liu92], independent
/// of any BLAS. The blocks are read where they stand; beside the factor there is an arena for what
/// fronts leave for their parents. In parallel over the subtrees and inside of the fronts above
/// them; sums are ordered by the tree alone, so that the bits are the same for any number of
/// threads. Use it from one thread at a time.
class SupernodalCholesky {
 public:
  /// `pool` outlives it. `set` is meant for tests. Throws std::bad_alloc.
  SupernodalCholesky(const SymmetricPattern& pattern, Supernodes supernodes, ThreadPool& pool,
                     InstructionSet set = instruction_set());

  /// Bytes of factor, arena and lists, the matrix itself included.
  static double memory(const SymmetricPattern& pattern, const Supernodes& supernodes, int threads);

  /// A in sparse storage, of the pattern. False when it is not positive definite to working
  /// precision or not finite: pivots are judged as DenseCholesky does.
  bool factor(const SymmetricBlocks& A);
  /// x <- A^-1 x, after a successful factor().
  void solve(double* x);

 private:
  /// A block of the matrix in the front of its first column; row and column in scalars.
  struct Entry {
    std::int64_t position;  // in the pattern
    std::int32_t block_row;
    std::int32_t row, column;
  };
  struct Task {
    std::int32_t front;
    double* arena;  // of a lane
    bool alone;     // the other lanes have work of their own
  };

  void find_entries(const SymmetricPattern& pattern);
  PackedTriangle triangle(const FrontLayout::Front& front) const;
  PackedRows rows(const FrontLayout::Front& front) const;
  double* kept(std::int32_t s, double* lane_arena) const;
  double* entry_at(const FrontLayout::Front& front, std::int64_t row, std::int64_t column) const;

  void factor_subtree(const SymmetricBlocks& A, const FrontLayout::Subtree& subtree, double* arena);
  bool factor_front(const SymmetricBlocks& A, const Task& task);
  template <class Body>
  void for_pieces(const Task& task, std::int64_t count, std::int64_t grain, Body&& body);
  void clear(const Task& task);
  void add_matrix(const SymmetricBlocks& A, const Task& task);
  void add_block(const SymmetricBlocks& A, const FrontLayout::Front& front, const Entry& entry);
  void add_child(std::int32_t child, const Task& task);
  void subtract_squares(const Task& task);
  template <class Visit>
  void for_rows(std::int32_t f, Visit&& visit) const;
  void forward(std::int32_t f);
  void backward(std::int32_t f);

  ThreadPool& pool_;
  const DenseKernels& kernels_;
  Supernodes supernodes_;
  FrontLayout layout_;
  TiledCholesky tiled_;
  std::vector<std::int64_t> entry_begin_;  // of supernode s: entries_[entry_begin_[s]] ...
  std::vector<Entry> entries_;
  LargeVector<double> storage_;  // factor, pivots, shared arena, arenas of the lanes
  double* values_ = nullptr;
  double* pivots_ = nullptr;
  double* shared_ = nullptr;
  double* lanes_ = nullptr;
  std::vector<std::int64_t> begin_;  // of the block at a place, in the matrix
  std::vector<double> x_;            // in the order of elimination
  std::vector<double> own_;          // of a front, in solve()
  std::vector<double> below_;
  std::atomic<bool> failed_{false};
};

}  // namespace raybundle::linalg
