// E = x X + y Y + z Z + W, where X, Y, Z, W span the matrices that the five pairs allow. What makes
// a matrix essential, det E = 0 and 2 E E^T E = trace(E E^T) E, are ten polynomials of third
// degree in x, y, z. They leave the ten monomials of lower degree as a basis of all polynomials,
// in which multiplication by x is a matrix; its eigenvectors are the monomials at the solutions.
//
// Polynomials are rows of coefficients, in this order:
//   degree 1   x y z 1
//   degree 2   x2 xy xz y2 yz z2 x y z 1
//   degree 3   x3 x2y x2z xy2 xyz xz2 y3 y2z yz2 z3, and those of degree 2

#include <raybundle/solver/init/five_point.h>

#include <raybundle/solver/init/real_eigen.h>

#include <cmath>
#include <utility>

namespace raybundle::init {
namespace {

using First = Eigen::Matrix<double, 1, 4>;
using Second = Eigen::Matrix<double, 1, 10>;
using Third = Eigen::Matrix<double, 1, 20>;
using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 10, 20>;

Second times(const First& p, const First& q) {
  Second r;
  r << p[0] * q[0], p[0] * q[1] + p[1] * q[0], p[0] * q[2] + p[2] * q[0], p[1] * q[1],
      p[1] * q[2] + p[2] * q[1], p[2] * q[2], p[0] * q[3] + p[3] * q[0], p[1] * q[3] + p[3] * q[1],
      p[2] * q[3] + p[3] * q[2], p[3] * q[3];
  return r;
}

Third times(const Second& p, const First& q) {
  Third r;
  r << p[0] * q[0], p[0] * q[1] + p[1] * q[0], p[0] * q[2] + p[2] * q[0], p[1] * q[1] + p[3] * q[0],
      p[1] * q[2] + p[2] * q[1] + p[4] * q[0], p[2] * q[2] + p[5] * q[0], p[3] * q[1],
      p[3] * q[2] + p[4] * q[1], p[4] * q[2] + p[5] * q[1], p[5] * q[2], p[0] * q[3] + p[6] * q[0],
      p[1] * q[3] + p[6] * q[1] + p[7] * q[0], p[2] * q[3] + p[6] * q[2] + p[8] * q[0],
      p[3] * q[3] + p[7] * q[1], p[4] * q[3] + p[7] * q[2] + p[8] * q[1], p[5] * q[3] + p[8] * q[2],
      p[6] * q[3] + p[9] * q[0], p[7] * q[3] + p[9] * q[1], p[8] * q[3] + p[9] * q[2], p[9] * q[3];
  return r;
}

// Gauss-Jordan elimination of the first rows() columns, which become the identity's. Where columns
// may be exchanged the largest number left is the pivot, and `order` follows them, else the largest
// of its column. Numbers are not finite where the matrix is singular.
template <class Matrix>
void eliminate(Matrix& M, Eigen::VectorXi* order) {
  for (Eigen::Index i = 0; i < M.rows(); ++i) {
    const Eigen::Index rows = M.rows() - i, columns = order ? M.cols() - i : 1;
    Eigen::Index row = 0, column = 0;
    M.block(i, i, rows, columns).cwiseAbs().maxCoeff(&row, &column);
    M.row(i).swap(M.row(i + row));
    M.col(i).swap(M.col(i + column));
    if (order) std::swap((*order)[i], (*order)[i + column]);
    M.row(i) /= double{M(i, i)};
    for (Eigen::Index k = 0; k < M.rows(); ++k) {
      if (k != i) M.row(k) -= double{M(k, i)} * M.row(i);
    }
  }
}

// A basis of the matrices with b_k^T E a_k = 0: row 3 i + j is entry (i, j).
Eigen::Matrix<double, 9, 4> allowed_matrices(const FiveRays& a, const FiveRays& b) {
  Eigen::Matrix<double, 5, 9> pairs;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      pairs.col(3 * i + j) = b.row(i).cwiseProduct(a.row(j)).transpose();
    }
  }
  Eigen::VectorXi order = Eigen::VectorXi::LinSpaced(9, 0, 8);
  eliminate(pairs, &order);
  Eigen::Matrix<double, 9, 4> basis = Eigen::Matrix<double, 9, 4>::Zero();
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i < 5; ++i) basis(order[i], k) = -pairs(i, 5 + k);
    basis(order[5 + k], k) = 1;
  }
  return basis;
}

Small constraints(const Eigen::Matrix<double, 9, 4>& basis) {
  const auto E = [&](int i, int j) -> First { return basis.row(3 * i + j); };
  // Lambda = E E^T - 1/2 trace(E E^T) I; then Lambda E = 0.
  Second lambda[3][3], trace = Second::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      lambda[i][j] = times(E(i, 0), E(j, 0)) + times(E(i, 1), E(j, 1)) + times(E(i, 2), E(j, 2));
      lambda[j][i] = lambda[i][j];
    }
    trace += lambda[i][i];
  }
  for (int i = 0; i < 3; ++i) lambda[i][i] -= 0.5 * trace;

  Small M(10, 20);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      M.row(3 * i + j) = times(lambda[i][0], E(0, j)) + times(lambda[i][1], E(1, j)) +
                         times(lambda[i][2], E(2, j));
    }
  }
  const auto minor = [&](int j, int k) -> Second {
    return times(E(1, j), E(2, k)) - times(E(1, k), E(2, j));
  };
  M.row(9) =
      times(minor(1, 2), E(0, 0)) - times(minor(0, 2), E(0, 1)) + times(minor(0, 1), E(0, 2));
  return M;
}

// Multiplication by x of the monomials of degree 2 and less.
SmallSquare multiplication_by_x(Small M) {
  eliminate(M, nullptr);
  SmallSquare action = SmallSquare::Zero(10, 10);
  action.topRows(6) = -M.topRightCorner(6, 10);  // x times x2 xy xz y2 yz z2
  action(6, 0) = action(7, 1) = action(8, 2) = action(9, 6) = 1;
  return action;
}

}  // namespace

EssentialMatrices essential_matrices(const FiveRays& a, const FiveRays& b) {
  EssentialMatrices result;
  const Eigen::Matrix<double, 9, 4> basis = allowed_matrices(a, b);
  const SmallSquare action = multiplication_by_x(constraints(basis));
  for (const RealEigen& eigen : real_eigen(action, 0)) {
    const Eigen::Vector4d at = eigen.vector.tail<4>();  // x y z 1
    const Eigen::Matrix<double, 9, 1> entries = basis * at;
    const double norm = entries.norm();
    if (!(norm > 0) || !std::isfinite(norm)) continue;
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> E(entries.data());
    result.add(E * (std::sqrt(2.0) / norm));
  }
  return result;
}

}  // namespace raybundle::init
