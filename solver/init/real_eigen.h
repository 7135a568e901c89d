#pragma once

#include <Eigen/Core>

#include <vector>

namespace raybundle::init {

/// Up to 10 x 10, on the stack.
using SmallSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 10, 10>;

struct RealEigen {
  double value;
  Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 10, 1> vector;
};

/// The real eigenvalues of a matrix with their vectors, of any length; those too whose imaginary
/// part is at most `tolerance` times their size, as double ones come out, by their real parts. None
/// of a matrix that is not finite. In a unit of its own, which takes a compiler long enough.
std::vector<RealEigen> real_eigen(const SmallSquare& A, double tolerance);

}  // namespace raybundle::init
