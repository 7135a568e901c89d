#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace raybundle::test {

/// The Jacobian (m x n) of f: R^n -> R^m at x by central differences with one Richardson
/// extrapolation: error O(h^4), about 1e-11 |f| / scale for a smooth f.
/// `scale` is the length over which f changes noticeably along a coordinate, relative to
/// max(1, |x_i|); the step is a thousandth of that. `f` takes and returns Eigen vectors.
template <class Function>
Eigen::MatrixXd numeric_jacobian(const Function& f, const Eigen::VectorXd& x, double scale = 1.0) {
  const auto difference = [&](Eigen::Index i, double h) -> Eigen::VectorXd {
    Eigen::VectorXd right = x;
    Eigen::VectorXd left = x;
    right[i] += h;
    left[i] -= h;
    const double width = right[i] - left[i];  // what was really moved, after rounding
    const Eigen::VectorXd f_right = f(right);
    const Eigen::VectorXd f_left = f(left);
    return (f_right - f_left) / width;
  };
  Eigen::MatrixXd J;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double h = 1e-3 * scale * std::max(1.0, std::abs(x[i]));
    const Eigen::VectorXd column = (4 * difference(i, 0.5 * h) - difference(i, h)) / 3;
    if (i == 0) J.resize(column.size(), x.size());
    J.col(i) = column;
  }
  return J;
}

/// The gradient of f: R^n -> R at x, in the same way.
template <class Function>
Eigen::VectorXd numeric_gradient(const Function& f, const Eigen::VectorXd& x, double scale = 1.0) {
  const auto as_vector = [&](const Eigen::VectorXd& y) {
    return Eigen::VectorXd::Constant(1, f(y));
  };
  return numeric_jacobian(as_vector, x, scale).transpose();
}

}  // namespace raybundle::test
