#pragma once

#include <raybundle/linalg/block_jacobian.h>
#include <raybundle/linalg/parallel.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/problem.h>

#include <cstdint>

#include <Eigen/Core>

namespace raybundle::test {

/// An Objective at the state of a problem, with its Jacobian as a dense matrix.
class DenseObjective {
 public:
  DenseObjective(const Problem& problem, PoseUpdate update, Lens lens, int threads = 2,
                 const RobustLoss& loss = {})
      : pool_(threads),
        objective_(problem, update, lens, pool_, loss),
        state_(Objective::state_of(problem)),
        J_(objective_.layout()),
        residual_(objective_.layout().residuals()) {
    cost_ = objective_.linearize(state_, residual_.data(), J_);
  }
  DenseObjective(const DenseObjective&) = delete;
  DenseObjective& operator=(const DenseObjective&) = delete;

  Objective& objective() { return objective_; }
  linalg::ThreadPool& pool() { return pool_; }
  const State& state() const { return state_; }
  const linalg::BlockJacobian& blocks() const { return J_; }
  Eigen::Index hubs() const { return objective_.layout().hubs; }
  Eigen::Index hub_size() const { return objective_.layout().hub_size; }
  double cost() const { return cost_; }  ///< as linearize() gave it
  const Eigen::VectorXd& residual() const { return residual_; }

  State after(const Eigen::VectorXd& step) {
    State next = state_;
    objective_.retract(state_, step.data(), next);
    return next;
  }

  Eigen::VectorXd residual_after(const Eigen::VectorXd& step) {
    linalg::BlockJacobian unused(objective_.layout());
    Eigen::VectorXd r(residual_.size());
    objective_.linearize(after(step), r.data(), unused);
    return r;
  }

  double cost_after(const Eigen::VectorXd& step) { return objective_.cost(after(step)); }

  Eigen::MatrixXd jacobian() const {
    using linalg::index;
    const linalg::BlockLayout& layout = objective_.layout();
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(layout.residuals(), layout.unknowns());
    for (std::int64_t c = 0; c < layout.couplings; ++c) {
      const bool repeats = !layout.coupling_rows.empty();
      const std::int64_t first = repeats ? layout.coupling_rows[index(c)] : c;
      const std::int64_t last = repeats ? layout.coupling_rows[index(c + 1)] : c + 1;
      const std::int64_t hub = std::int64_t{layout.hub_side.block[index(c)]} * layout.hub_size;
      const std::int64_t leaf = layout.offset(linalg::Side::leaves) +
                                std::int64_t{layout.leaf_side.block[index(c)]} * layout.leaf_size;
      for (std::int64_t i = 2 * first; i < 2 * last; ++i) {
        for (int k = 0; k < layout.hub_size; ++k) {
          dense(i, hub + k) = J_.hub_blocks[index(i * layout.hub_size + k)];
        }
        for (int k = 0; k < layout.leaf_size; ++k) {
          dense(i, leaf + k) = J_.leaf_blocks[index(i * layout.leaf_size + k)];
        }
      }
    }
    return dense;
  }

 private:
  linalg::ThreadPool pool_;
  Objective objective_;
  State state_;
  linalg::BlockJacobian J_;
  Eigen::VectorXd residual_;
  double cost_ = 0;
};

}  // namespace raybundle::test
