#pragma once

#include <raybundle/linalg/cholesky.h>
#include <raybundle/linalg/parallel.h>

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace raybundle::init {

/// A symmetric positive definite matrix of size x size blocks, 1 or 3, over the images of a graph;
/// its sparsity never changes.
template <int size>
class PoseGraphSystem {
 public:
  using Couple = std::pair<std::int32_t, std::int32_t>;
  using Block = Eigen::Matrix<double, size, size>;

  /// Blocks on the diagonal, and those of `couples` in any order, also more than once. Throws
  /// MemoryRefusal.
  PoseGraphSystem(std::int64_t images, std::vector<Couple> couples, linalg::ThreadPool& pool);

  void set_zero();
  /// Remembers what has been added so far, or goes back to it.
  void keep();
  void restore();
  /// Adds `block` at rows of a and columns of b, and its transpose across the diagonal.
  void add(std::int32_t a, std::int32_t b, const Block& block);
  /// Rows and columns of the image become those of the identity; after all is added.
  void hold(std::int32_t image);

  /// False where the matrix is not positive definite. What was added is spent.
  bool factor() { return cholesky_->factor(); }
  /// x := A^-1 x, column by column, after a successful factor().
  void solve(Eigen::Ref<Eigen::MatrixXd> x);

 private:
  double* block_at(std::int32_t a, std::int32_t b);
  std::int64_t stride(std::int32_t a) const { return cholesky_->matrix().stride(a); }

  std::unique_ptr<linalg::Cholesky> cholesky_;
  std::vector<double> kept_;
};

extern template class PoseGraphSystem<1>;
extern template class PoseGraphSystem<3>;

}  // namespace raybundle::init
