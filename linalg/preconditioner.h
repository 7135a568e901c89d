#pragma once

#include <raybundle/linalg/reduced_system.h>

namespace raybundle::linalg {

/// z = N^-1 r for a (block) diagonal N, or z = r. [Qu18, 3.3.5] calls the matrix M.
class Preconditioner {
 public:
  enum class Form { identity, diagonal, blocks };

  /// Takes the blocks, or their diagonals; blocks that are not definite act as their
  /// pseudo-inverse.
  void build(Form form, const DiagonalBlocks& blocks, ThreadPool& pool);
  void apply(const double* r, double* z, std::int64_t size, ThreadPool& pool) const;

 private:
  void apply_blocks(const DiagonalBlocks::Run& run, const double* r, double* z,
                    ThreadPool& pool) const;

  Form form_ = Form::identity;
  std::vector<double> inverse_;  // of the diagonal
  DiagonalBlocks factors_;       // F with F F^T = N^-1
};

}  // namespace raybundle::linalg
