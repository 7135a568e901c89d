#include <raybundle/linalg/dense_cholesky.h>

#include <cstddef>
#include <limits>

namespace raybundle::linalg {

DenseCholesky::DenseCholesky(std::int64_t order, InstructionSet set)
    : order_(order),
      kernels_(&dense_kernels(set)),
      strips_(ceil_div(order, kernels_->strip)),
      tiled_(*kernels_, strips_) {
  const std::int64_t strip = kernels_->strip;
  const std::int64_t padded = strips_ * strip;
  packed_.resize(static_cast<std::size_t>(strip * strip / 2 * strips_ * (strips_ + 1)));
  inverse_diagonal_.resize(static_cast<std::size_t>(padded));
  threshold_.resize(static_cast<std::size_t>(padded));
  triangle_ = {order_, packed_.data(), inverse_diagonal_.data(), threshold_.data()};
}

bool DenseCholesky::factor(double* A, std::int64_t ld, ThreadPool& pool) {
  if (order_ == 0) return true;
  set_thresholds(A, ld);
  const TiledCholesky::Matrix matrix = {A, ld};
  return tiled_.factor(triangle_, pool, &matrix);
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

}  // namespace raybundle::linalg
