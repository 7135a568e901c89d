#pragma once

#include <raybundle/linalg/pcg.h>

#include <cstdint>
#include <random>

#include <Eigen/Core>

#include <raybundle/tests/support/random_problem.h>

namespace raybundle::test {

/// Entries uniform in [-1, 1).
inline Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(random); });
}

struct PcgSolution {
  linalg::Pcg::Result result;
  Eigen::VectorXd x;
};

/// Conjugate gradients on dense matrices, with the preconditioner N^-1 given as one.
inline PcgSolution solve_dense(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                               const linalg::Pcg::Stop& stop, const Eigen::MatrixXd& N_inverse) {
  using Eigen::VectorXd;
  const Eigen::Index n = b.size();
  linalg::ThreadPool pool(2);
  linalg::Pcg pcg(n, pool);
  PcgSolution solution{{}, VectorXd::Constant(n, 1e300)};
  const auto product = [n](const Eigen::MatrixXd& M) {
    return [&M, n](const double* x, double* y) {
      Eigen::Map<VectorXd>(y, n) = M * Eigen::Map<const VectorXd>(x, n);
    };
  };
  solution.result = pcg.solve(product(A), product(N_inverse), b.data(), stop, solution.x.data());
  return solution;
}

inline PcgSolution solve_dense(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                               const linalg::Pcg::Stop& stop) {
  return solve_dense(A, b, stop, Eigen::MatrixXd::Identity(b.size(), b.size()));
}

}  // namespace raybundle::test
