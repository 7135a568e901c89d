#pragma once

#include <raybundle/linalg/block_jacobian.h>
#include <raybundle/linalg/parallel.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/problem.h>

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

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
        objective_(problem, formulation, pool_, loss),
        state_(objective_.state_of(problem)),
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
    const auto place = [&](const std::vector<double>& blocks, std::int64_t block, std::int64_t row,
                           std::int64_t column, int size) {
      for (int i = 0; i < layout.row_size; ++i) {
        for (int k = 0; k < size; ++k) {
          dense(row * layout.row_size + i, column + k) =
              blocks[index((block * layout.row_size + i) * size + k)];
        }
      }
    };
    for (std::int64_t c = 0; c < layout.couplings; ++c) {
      const std::int64_t hub = std::int64_t{layout.hub_side.block[index(c)]} * layout.hub_size;
      const std::int64_t leaf = layout.offset(linalg::Side::leaves) +
                                std::int64_t{layout.leaf_side.block[index(c)]} * layout.leaf_size;
      for (const auto& [part, row] : parts_of(c)) {
        place(J_.hub_blocks, part, row, hub, layout.hub_size);
        place(J_.leaf_blocks, row, row, leaf, layout.leaf_size);
      }
    }
    return dense;
  }

 private:
  // Part and row of what a coupling consists of.
  std::vector<std::pair<std::int64_t, std::int64_t>> parts_of(std::int64_t c) const {
    using linalg::index;
    const linalg::BlockLayout& layout = objective_.layout();
    std::vector<std::pair<std::int64_t, std::int64_t>> result;
    if (layout.several_parts()) {
      const linalg::RowParts& parts = layout.parts;
      for (auto k = parts.coupling_begin[index(c)]; k < parts.coupling_begin[index(c + 1)]; ++k) {
        result.emplace_back(parts.list[index(k)], parts.row[index(parts.list[index(k)])]);
      }
      return result;
    }
    const bool repeats = !layout.coupling_rows.empty();
    const std::int64_t first = repeats ? layout.coupling_rows[index(c)] : c;
    const std::int64_t last = repeats ? layout.coupling_rows[index(c + 1)] : c + 1;
    for (std::int64_t row = first; row < last; ++row) result.emplace_back(row, row);
    return result;
  }

  linalg::ThreadPool pool_;
  Objective objective_;
  State state_;
  linalg::BlockJacobian J_;
  Eigen::VectorXd residual_;
  double cost_ = 0;
};

}  // namespace raybundle::test
