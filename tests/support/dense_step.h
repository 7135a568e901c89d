#pragma once

#include <raybundle/linalg/normal_equations.h>
#include <raybundle/solver/step.h>

#include <memory>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <raybundle/tests/support/dense_objective.h>

namespace raybundle::test {

/// The damped system of a step, densely: (H + mu D) p = -g, and its model
/// m(p) = cost + g^T p + 1/2 p^T (H + mu D) p [Qu18, Eq. 2.53]. Everything is computed in unknowns
/// scaled to a unit diagonal, so that their units cost no accuracy.
class DenseStep {
 public:
  DenseStep(const DenseObjective& at, DiagonalMatrix damping_matrix, double mu) {
    const Eigen::MatrixXd J = at.jacobian();
    gradient = J.transpose() * at.residual();
    H = J.transpose() * J;
    diagonal = H.diagonal();
    damping = Eigen::VectorXd::Constant(H.rows(), mu);
    if (damping_matrix == DiagonalMatrix::diag_h) {
      damping = mu * diagonal.cwiseMax(min_diagonal).cwiseMin(max_diagonal);
    }
    H_damped = H;
    H_damped.diagonal() += damping;
    unit = H_damped.diagonal().cwiseSqrt().cwiseInverse();
  }

  /// The exact step.
  Eigen::VectorXd step() const {
    const Eigen::MatrixXd scaled = unit.asDiagonal() * H_damped * unit.asDiagonal();
    const Eigen::VectorXd right = -unit.cwiseProduct(gradient);
    return unit.cwiseProduct(scaled.ldlt().solve(right));
  }

  /// m(0) - m(p).
  double decrease(const Eigen::VectorXd& p) const {
    return -gradient.dot(p) - 0.5 * p.dot(H_damped * p);
  }

  /// |p - q| in units that make all unknowns alike.
  double distance(const Eigen::VectorXd& p, const Eigen::VectorXd& q) const {
    return (p - q).cwiseQuotient(unit).norm();
  }
  double length(const Eigen::VectorXd& p) const { return p.cwiseQuotient(unit).norm(); }

  Eigen::MatrixXd H, H_damped;
  Eigen::VectorXd gradient, diagonal, damping, unit;
};

/// A step solver and the linearisation it works on.
class StepFixture {
 public:
  StepFixture(DenseObjective& at, const Options& options)
      : at_(at),
        options_(resolve(options)),
        normal_(at.objective().layout()),
        solver_(make_step_solver(options_, at.objective().layout(), at.pool())) {
    normal_.form(at.blocks(), at.residual().data(), at.pool());
  }

  struct Result {
    StepReport report;
    Eigen::VectorXd step;
  };

  Result solve(const Eigen::VectorXd& damping) {
    Result result;
    result.step = Eigen::VectorXd::Constant(damping.size(), 1e300);
    const linalg::Linearization linearization = {&at_.blocks(), &normal_, at_.residual().data()};
    result.report = solver_->solve(linearization, damping.data(), result.step.data());
    return result;
  }

  const StepSolver& solver() const { return *solver_; }

 private:
  DenseObjective& at_;
  Options options_;
  linalg::NormalEquations normal_;
  std::unique_ptr<StepSolver> solver_;
};

}  // namespace raybundle::test
