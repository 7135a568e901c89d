#include <raybundle/linalg/block_factor.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <cmath>

namespace raybundle::linalg {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, 12, 12>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 12, 1>;

}  // namespace

void inverse_factor(const double* A, int size, double* M) {
  const Matrix block = Eigen::Map<const Matrix>(A, size, size);
  const Eigen::LLT<Matrix> llt(block);
  const Vector pivots = llt.matrixLLT().diagonal();
  const Vector squares = pivots.cwiseAbs2();
  const bool regular = llt.info() == Eigen::Success && squares.allFinite() &&
                       (squares.array() > pivot_tolerance * block.diagonal().array()).all();
  if (!regular) {
    pseudo_inverse_factor(A, size, M);
    return;
  }
  Eigen::Map<Matrix> factor(M, size, size);
  factor.setIdentity();
  llt.matrixU().solveInPlace(factor);
}

void pseudo_inverse_factor(const double* A, int size, double* M) {
  Eigen::Map<Matrix> factor(M, size, size);
  factor.setZero();
  const Matrix block = Eigen::Map<const Matrix>(A, size, size);
  if (!block.allFinite()) return;

  Vector scale(size);
  for (int i = 0; i < size; ++i) scale[i] = block(i, i) > 0 ? 1 / std::sqrt(block(i, i)) : 0;
  const Matrix scaled = scale.asDiagonal() * block * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(scaled);
  if (eigen.info() != Eigen::Success) return;
  const double smallest = size * null_tolerance * eigen.eigenvalues()[size - 1];
  for (int k = 0; k < size; ++k) {
    const double value = eigen.eigenvalues()[k];
    if (value > smallest) {
      factor.col(k) = scale.cwiseProduct(eigen.eigenvectors().col(k)) / std::sqrt(value);
    }
  }
}

}  // namespace raybundle::linalg
