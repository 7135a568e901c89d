#pragma once

#include <raybundle/linalg/block_jacobian.h>
#include <raybundle/linalg/parallel.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/problem.h>

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <raybundle/tests/support/block_system.h>

namespace raybundle::test {

/// An Objective at the state of a problem, with its Jacobian as a dense matrix.
class DenseObjective {
 public:
  DenseObjective(const Problem& problem, PoseUpdate update, Lens lens, int threads = 2,
                 const RobustLoss& loss = {})
      : DenseObjective(problem, {.pose_update = update, .lens = lens}, threads, loss) {}
  DenseObjective(const Problem& problem, const Formulation& formulation, int threads = 2,
                 const RobustLoss& loss = {})
      : pool_(threads),
        problem_(problem),
        objective_(problem_, formulation, pool_, loss),
        state_(objective_.state_of(problem)),
        J_(objective_.layout()),
        normal_(objective_.layout()),
        residual_(objective_.layout().residuals()) {
    cost_ = objective_.linearize(state_, J_, normal_, residual_.data());
  }
  DenseObjective(const DenseObjective&) = delete;
  DenseObjective& operator=(const DenseObjective&) = delete;

  Objective& objective() { return objective_; }
  linalg::ThreadPool& pool() { return pool_; }
  const State& state() const { return state_; }
  const linalg::BlockJacobian& blocks() const { return J_; }
  const linalg::NormalEquations& normal() const { return normal_; }
  /// Whether all rows are the same to the last bit.
  bool same_rows(const DenseObjective& other) const {
    for (std::int64_t row = 0; row < J_.layout().rows; ++row) {
      for (const linalg::Side side : {linalg::Side::hubs, linalg::Side::leaves}) {
        if (row_block(J_, side, row) != row_block(other.J_, side, row)) return false;
      }
    }
    return true;
  }
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
    linalg::NormalEquations normal(objective_.layout());
    objective_.linearize(after(step), unused, normal, r.data());
    return r;
  }

  double cost_after(const Eigen::VectorXd& step) { return objective_.cost(after(step)); }

  Eigen::MatrixXd jacobian() const {
    using linalg::index;
    const linalg::BlockLayout& layout = objective_.layout();
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(layout.residuals(), layout.unknowns());
    const auto place = [&](linalg::Side side, std::int64_t row, std::int64_t column) {
      dense.block(row * layout.row_size, column, layout.row_size, layout.block_size(side)) =
          row_block(J_, side, row);
    };
    for (std::int64_t c = 0; c < layout.couplings; ++c) {
      const std::int64_t hub = std::int64_t{layout.hub_side.block[index(c)]} * layout.hub_size;
      const std::int64_t leaf = layout.offset(linalg::Side::leaves) +
                                std::int64_t{layout.leaf_side.block[index(c)]} * layout.leaf_size;
      const bool repeats = !layout.coupling_rows.empty();
      const std::int64_t first = repeats ? layout.coupling_rows[index(c)] : c;
      const std::int64_t last = repeats ? layout.coupling_rows[index(c + 1)] : c + 1;
      for (std::int64_t row = first; row < last; ++row) {
        place(linalg::Side::hubs, row, hub);
        place(linalg::Side::leaves, row, leaf);
      }
    }
    if (layout.anchored()) add_anchors(dense);
    return dense;
  }

 private:
  // What all rows of a leaf feel of its anchors: J_leaf Z.
  void add_anchors(Eigen::MatrixXd& dense) const {
    using linalg::index;
    const linalg::BlockLayout& layout = objective_.layout();
    using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const Eigen::Index K = layout.hub_size, E = layout.leaf_size;
    for (std::int64_t l = 0; l < layout.leaves; ++l) {
      const Eigen::MatrixXd J_leaf =
          dense.middleCols(layout.offset(linalg::Side::leaves) + l * E, E);
      for (auto k = layout.anchorage.begin[index(l)]; k < layout.anchorage.begin[index(l + 1)];
           ++k) {
        const Eigen::Map<const Block> Z(J_.anchor_blocks.data() + k * E * K, E, K);
        const std::int64_t coupling = layout.anchorage.coupling[index(k)];
        dense.middleCols(layout.hub_side.block[index(coupling)] * K, K) += J_leaf * Z;
      }
    }
  }

  linalg::ThreadPool pool_;
  Problem problem_;
  Objective objective_;
  State state_;
  linalg::BlockJacobian J_;
  linalg::NormalEquations normal_;
  Eigen::VectorXd residual_;
  double cost_ = 0;
};

}  // namespace raybundle::test
