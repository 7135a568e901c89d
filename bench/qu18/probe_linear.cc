#include <algorithm>
#include <chrono>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/LU>

#include <raybundle/bench/qu18/probe.h>
#include <raybundle/linalg/cholesky.h>
#include <raybundle/linalg/pcg.h>

namespace raybundle::bench {
namespace {

using Eigen::VectorXd;
using linalg::Side;

/// The reduced camera system of one linearisation, solved in three ways.
class ReducedSolver {
 public:
  explicit ReducedSolver(const Linearised& at)
      : at_(at),
        system_(linalg::make_reduced_system(at.layout(), Side::leaves, at.pool)),
        pcg_(system_->size(), at.pool),
        cholesky_(
            linalg::Cholesky::make(linalg::plan_cholesky(system_->pattern(), at.pool.threads(),
                                                         linalg::CholeskyKind::dense),
                                   at.pool)),
        v_(system_->size()),
        x_(system_->size()) {}

  /// [Qu18, 3.3.1]: until |r| < 0.1 |b|, without forming S_C.
  VectorXd by_cg(const double* damping) {
    system_->prepare(at_.view(), damping);
    system_->gradient(v_.data());
    v_ = -v_;
    const linalg::Pcg::Stop stop{.residual = 0.1 * v_.norm(), .max_iterations = 1000};
    const auto copy = [this](const double* x, double* y) { std::copy_n(x, v_.size(), y); };
    iterations += pcg_.solve([this](const double* x, double* y) { system_->apply(x, y); }, copy,
                             v_.data(), stop, x_.data())
                      .iterations;
    return expanded();
  }

  VectorXd by_cholesky(const double* damping) {
    system_->prepare(at_.view(), damping);
    system_->assemble(cholesky_->matrix(), v_.data());
    if (!cholesky_->factor()) return VectorXd::Constant(at_.layout().unknowns(), NAN);
    x_ = -v_;
    cholesky_->solve(x_.data());
    return expanded();
  }

  VectorXd by_lu(const double* damping) {
    system_->prepare(at_.view(), damping);
    system_->assemble(cholesky_->matrix(), v_.data());
    const auto n = v_.size();
    const Eigen::Map<const Eigen::MatrixXd> lower(cholesky_->matrix().values(), n, n);
    const Eigen::MatrixXd S = lower.selfadjointView<Eigen::Lower>();
    x_ = S.partialPivLu().solve(-v_);
    return expanded();
  }

  long long iterations = 0;

 private:
  VectorXd expanded() {
    VectorXd step(at_.layout().unknowns());
    system_->expand(x_.data(), step.data());
    return step;
  }

  const Linearised& at_;
  std::unique_ptr<linalg::ReducedSystem> system_;
  linalg::Pcg pcg_;
  std::unique_ptr<linalg::Cholesky> cholesky_;
  VectorXd v_, x_;
};

struct Timed {
  VectorXd step;
  double seconds;
};

template <class Solve>
Timed timed(const Solve& solve) {
  const auto start = std::chrono::steady_clock::now();
  VectorXd step = solve();
  return {std::move(step),
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()};
}

}  // namespace

Json linear_solvers(const Problem& problem, int systems, linalg::ThreadPool& pool) {
  Linearised at(problem, pool);
  ReducedSolver solver(at);
  State state = at.objective.state_of(problem), next = state;
  const auto s = at.layout().unknowns();
  double seconds[3] = {}, difference[3] = {}, relative = 0, length = 0, mu = 1;
  for (int k = 0; k < systems; ++k) {
    const double cost = at.at(state);
    const VectorXd damping = VectorXd::Constant(s, mu);
    const Timed cg = timed([&] { return solver.by_cg(damping.data()); });
    const Timed cd = timed([&] { return solver.by_cholesky(damping.data()); });
    const Timed lu = timed([&] { return solver.by_lu(damping.data()); });
    const Timed* each[3] = {&cg, &cd, &lu};
    for (int i = 0; i < 3; ++i) seconds[i] += each[i]->seconds / systems;
    const double scale = 1.0 / (static_cast<double>(s) * systems);  // [Qu18, Eq. 3.83]
    difference[0] += (cg.step - cd.step).squaredNorm() * scale;
    difference[1] += (cg.step - lu.step).squaredNorm() * scale;
    difference[2] += (cd.step - lu.step).squaredNorm() * scale;
    length += cd.step.squaredNorm() * scale;
    relative += (cg.step - cd.step).norm() / cd.step.norm() / systems;
    at.objective.retract(state, cd.step.data(), next);
    const bool better = at.objective.cost(next) < cost;
    if (better) std::swap(state, next);
    mu = better ? std::max(mu / 3, 1e-6) : 4 * mu;
  }
  return {{"systems", systems},
          {"order", at.layout().size(Side::hubs)},
          {"seconds", {seconds[0], seconds[1], seconds[2]}},
          {"cg_iterations", static_cast<double>(solver.iterations) / systems},
          {"difference", {difference[0], difference[1], difference[2]}},
          {"cholesky_step", length},
          {"relative_cg_cholesky", relative}};
}

}  // namespace raybundle::bench
