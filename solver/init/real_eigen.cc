#include <raybundle/solver/init/real_eigen.h>

#include <Eigen/Eigenvalues>

#include <cmath>

namespace raybundle::init {

std::vector<RealEigen> real_eigen(const SmallSquare& A, double tolerance) {
  std::vector<RealEigen> result;
  if (!A.allFinite()) return result;
  const Eigen::EigenSolver<SmallSquare> eigen(A);
  if (eigen.info() != Eigen::Success) return result;
  const auto vectors = eigen.eigenvectors();
  for (Eigen::Index k = 0; k < A.rows(); ++k) {
    const auto value = eigen.eigenvalues()[k];
    if (std::abs(value.imag()) > tolerance * std::abs(value)) continue;
    result.push_back({value.real(), vectors.col(k).real()});
  }
  return result;
}

}  // namespace raybundle::init
