#pragma once

#include <raybundle/linalg/normal_equations.h>
#include <raybundle/models/camera_modes.h>
#include <raybundle/solver/diagonal_matrix.h>
#include <raybundle/solver/step.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <raybundle/tests/support/dense_objective.h>

namespace raybundle::test {

/// For the names of tests.
inline const char* letter(DiagonalMatrix matrix) {
  switch (matrix) {
    case DiagonalMatrix::identity:
      return "I";
    case DiagonalMatrix::inc:
      return "Inc";
    case DiagonalMatrix::diag_h:
      return "H";
    case DiagonalMatrix::held_h:
      return "HeldH";
  }
  return "";
}

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
    if (damping_matrix == DiagonalMatrix::diag_h || damping_matrix == DiagonalMatrix::held_h) {
      damping = mu * diagonal.cwiseMax(min_diagonal).cwiseMin(max_diagonal);
      if (damping_matrix == DiagonalMatrix::held_h) hold(at.hubs() * at.hub_size());
    } else if (damping_matrix == DiagonalMatrix::inc) {
      damping = mu * inc_matrix(at.hubs(), at.hub_size(), diagonal.size());
    }
    H_damped = H;
    H_damped.diagonal() += damping;
    unit = H_damped.diagonal().cwiseSqrt().cwiseInverse();
  }

  /// (increment of points / increment)^2 for every unknown, from the default increments.
  static Eigen::VectorXd inc_matrix(Eigen::Index hubs, Eigen::Index hub_size, Eigen::Index size) {
    const Increments inc = shipped_increments(PointModel::xyz);
    Eigen::VectorXd camera(9);
    camera << inc.rotation, inc.rotation, inc.rotation, inc.translation, inc.translation,
        inc.translation, inc.focal, inc.k1, inc.k2;
    Eigen::VectorXd d = Eigen::VectorXd::Ones(size);
    for (Eigen::Index c = 0; c < hubs; ++c) {
      d.segment(c * hub_size, hub_size) =
          (inc.point * camera.head(hub_size).cwiseInverse()).cwiseAbs2();
    }
    return d;
  }

  /// Damping of points, from `first` on, by at least held_share of the largest of each.
  void hold(Eigen::Index first) {
    for (Eigen::Index i = first; i < damping.size(); i += 3) {
      const double least = held_share * damping.segment<3>(i).maxCoeff();
      damping.segment<3>(i) = damping.segment<3>(i).cwiseMax(least);
    }
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
        solver_(make_step_solver(options_, at.objective().layout(), at.pool())) {
    const linalg::BlockLayout& layout = at.objective().layout();
    modes_.resize(
        linalg::index(layout.size(linalg::Side::hubs) * linalg::coarse_modes(layout.hub_size)));
    camera_modes(at.objective().formulation().pose_update, at.state().cameras, layout.hub_size,
                 modes_.data());
  }

  struct Result {
    StepReport report;
    Eigen::VectorXd step;
  };

  Result solve(const Eigen::VectorXd& damping,
               double radius = std::numeric_limits<double>::infinity(),
               std::optional<double> block_radius = {}, bool relinearised = true) {
    linalg::LargeVector<double> inverse;
    const DiagonalMatrix scaling = options_.scaling.value_or(DiagonalMatrix::identity);
    if (scaling != DiagonalMatrix::identity) {
      fill_diagonal(scaling, increments(options_), options_.points, at_.normal(), inverse,
                    at_.pool());
      for (double& d : inverse) d = 1 / std::sqrt(d);
    }
    Result result;
    result.step = Eigen::VectorXd::Constant(damping.size(), 1e300);
    const Forcing forcing(options_.forcing_rule.value_or(ForcingRule::thesis),
                          options_.forcing.value_or(0));
    const StepRequest request = {.at = {&at_.blocks(), &at_.normal(), modes_.data()},
                                 .relinearised = relinearised,
                                 .damping = damping.data(),
                                 .inverse_scaling = inverse.empty() ? nullptr : inverse.data(),
                                 .radius = radius,
                                 .block_radius = block_radius,
                                 .tolerance = forcing.tolerance()};
    result.report = solver_->solve(request, result.step.data());
    return result;
  }

  const StepSolver& solver() const { return *solver_; }

 private:
  DenseObjective& at_;
  Options options_;
  std::vector<double> modes_;
  std::unique_ptr<StepSolver> solver_;
};

}  // namespace raybundle::test
