// The damped and bounded Gauss-Newton loop [Qu18, Alg. 5, 8-11]. Per iteration, with H = J^T J,
// g = J^T r, a diagonal damping matrix D and a diagonal scaling D_s:
//
//   step         min m(p), exactly or not, subject to |D_s p| <= radius
//   model        m(p) = cost + g^T p + 1/2 p^T (H + mu D) p            [Qu18, Eq. 3.105]
//   rho          (cost - cost(x + p)) / (m(0) - m(p))                  [Qu18, Eq. 3.90]
//   verdict      rho > 0: x := x + p; mu [Qu18, Alg. 6] and radius [Qu18, Alg. 2] follow rho
//
// Before it is judged a step may lose the parts of points that are better off without (PointSteps).
// A method without damping has mu = 0, one without a region an infinite radius. The thesis retries
// inside an iteration until a step is accepted, without bound; here every trial is an iteration,
// and max_consecutive_failures, max_damping and min_radius bound the retries. With a robust loss, r
// and J are those of the reweighted problem [Qu18, Eq. 4.25-4.28], whose model has the cost's own
// slope.

#include <raybundle/solver/trust_region.h>

#include <raybundle/linalg/vector.h>
#include <raybundle/solver/methods.h>
#include <raybundle/solver/phase_timer.h>

#include <cmath>
#include <limits>
#include <new>
#include <utility>

namespace raybundle {
namespace {

using linalg::index;

constexpr std::int64_t vector_grain = 16384;

}  // namespace

TrustRegion::TrustRegion(Objective& objective, StepSolver& steps, linalg::ThreadPool& pool,
                         const Options& options, const Observer& observer, Clock::time_point start)
    : objective_(objective),
      steps_(steps),
      pool_(pool),
      observer_(observer),
      start_(start),
      J_(objective.layout(), options.precision.value_or(Precision::single_precision)),
      normal_(objective.layout()),
      damping_diagonal_(index(objective.layout().unknowns()), 0.0),
      step_(index(objective.layout().unknowns())),
      increments_(increments(options)),
      loss_(options),
      convergence_(options, objective.layout().residuals(), objective.rounding_cost()) {
  summary_.rounding = objective.rounding_cost();
  summary_.options = options;
  if (options.diagnose) diagnoser_.emplace(objective.layout(), pool);
  if (options.forcing) forcing_.emplace(*options.forcing_rule, *options.forcing);
  start_globalisation();
}

double TrustRegion::memory(const linalg::LayoutSize& n, const Options& options) {
  const bool retries = options.point_steps == PointSteps::better;
  const bool scaled =
      options.scaling.value_or(DiagonalMatrix::identity) != DiagonalMatrix::identity;
  const int vectors =
      2 + (traits(options.method).damped ? 1 : 0) + (scaled ? 1 : 0) + (retries ? 1 : 0);
  const double state =
      9 * static_cast<double>(n.hubs) + stored_size(options.points) * static_cast<double>(n.leaves);
  return 8 * (vectors * static_cast<double>(n.unknowns()) + 2 * state) +
         linalg::BlockJacobian::memory(n, options.precision.value_or(Precision::single_precision)) +
         linalg::NormalEquations::memory(n);
}

void TrustRegion::start_globalisation() {
  const Options& options = summary_.options;
  const MethodTraits& method = traits(options.method);
  if (method.damped) damping_.emplace(*options.initial_damping, *options.min_damping);
  if (method.bounded) radius_.emplace(options.initial_radius, method.radius);
  if (method.inner == InnerSolve::pcg && method.bounded && !method.damped)
    block_radius_.emplace(std::nullopt);
}

Summary TrustRegion::run(State& state) {
  state_ = std::move(state);
  candidate_ = state_;
  start();
  while (!stopped_) {
    try {
      iterate();
    } catch (const std::bad_alloc&) {
      stop(Termination::out_of_memory);
    }
  }
  state = std::move(state_);
  return std::move(summary_);
}

void TrustRegion::iterate() {
  begin_record();
  compute_step();
  if (step_valid_) {
    propose();
    evaluate_candidate();
  }
  judge();
  if (record_.accepted) {
    linearize();
    diagnose();
  }
  end_iteration();
}

void TrustRegion::start() {
  summary_.seconds.setup = seconds();
  record_.iteration = -1;
  begin_record();
  {
    const PhaseTimer timer(summary_.seconds.residual);
    summary_.initial_cost = cost_ = objective_.cost(state_);
  }
  if (!loss_.is_final()) set_loss_scale(loss_.scale());
  linearize();
  diagnose();
  record_.accepted = true;
  end_iteration();
  if (!std::isfinite(cost_ + record_.gradient_norm)) stop(Termination::bad_start);
}

void TrustRegion::begin_record() {
  IterationRecord next;
  next.iteration = record_.iteration + 1;
  next.cost = previous_cost_ = cost_;
  next.candidate_cost = next.rho = std::numeric_limits<double>::quiet_NaN();
  next.pixel_cost = record_.pixel_cost;
  next.gradient_norm = record_.gradient_norm;
  next.gradient_max = record_.gradient_max;
  next.damping = damping_ ? damping_->mu() : 0;
  next.radius = radius_ ? radius_->radius() : 0;
  next.eliminated = summary_.options.elimination.value_or(Elimination::points);
  next.condition_cameras = next.condition_points = std::numeric_limits<double>::quiet_NaN();
  next.loss_scale = loss_.scale();
  record_ = next;
}

void TrustRegion::compute_step() {
  const PhaseTimer timer(summary_.seconds.linear);
  fill_damping();
  StepRequest request = {
      .at = {&J_, &normal_, hub_modes_.data()},
      .relinearised = relinearised_,
      .damping = damping_diagonal_.data(),
      .inverse_scaling = inverse_scaling_.empty() ? nullptr : inverse_scaling_.data()};
  if (forcing_) request.tolerance = forcing_->tolerance();
  if (radius_) request.radius = radius_->radius();
  if (block_radius_) request.block_radius = block_radius_->radius();
  if (summary_.widened_at >= 0) request.grown = widening_memory();
  report_ = steps_.solve(request, step_.data());
  relinearised_ = false;
  summary_.linear_solves += report_.linear_solves;
  if (report_.linear_solves > 0 && report_.regularisation > 0) ++summary_.regularised;
  record_.regularisation = report_.regularisation;
  summary_.inner_iterations += report_.inner_iterations;
  record_.inner_iterations = report_.inner_iterations;
  record_.inner_capped = report_.inner_capped;
  record_.on_boundary = report_.on_boundary || report_.block_on_boundary;
  record_.eliminated = report_.eliminated;
  record_.condition_cameras = report_.condition_cameras;
  record_.condition_points = report_.condition_points;
  step_valid_ = report_.solved && step_is_finite();
}

bool TrustRegion::step_is_finite() const {
  return std::isfinite(
      linalg::largest_magnitude(step_.data(), static_cast<std::int64_t>(step_.size()), pool_));
}

// What is taken back is not promised either. The cameras' step counts on points that follow: where
// the model promises nothing without those that were taken back, all go.
void TrustRegion::propose() {
  if (points_stay()) {
    hold_points();
    return predict_decrease(std::nullopt);
  }
  if (summary_.options.point_steps == PointSteps::better) {
    const PhaseTimer timer(summary_.seconds.residual);
    whole_step_ = step_;
    record_.points_held = objective_.hold_worse_points(state_, step_.data(), candidate_);
  }
  if (record_.points_held == 0) return predict_decrease(report_.curvature);
  predict_decrease(std::nullopt);
  if (record_.predicted_decrease > 0) return;
  step_.swap(whole_step_);
  record_.points_held = 0;
  predict_decrease(report_.curvature);
}

// m(0) - m(p) = -g^T p - 1/2 |J p|^2 - 1/2 mu p^T D p, equal to [Qu18, Eq. 3.102] for every step
// whose eliminated part was back-substituted.
void TrustRegion::predict_decrease(const std::optional<double>& known_curvature) {
  const PhaseTimer timer(summary_.seconds.linear);
  const auto unknowns = static_cast<std::int64_t>(step_.size());
  const double slope = linalg::dot(normal_.gradient.data(), step_.data(), unknowns, pool_);
  const double curvature =
      known_curvature ? *known_curvature : linalg::multiply_squares(J_, step_.data(), pool_);
  const double damped = linalg::parallel_sum(
      pool_, unknowns, vector_grain, [&](std::int64_t first, std::int64_t last) {
        double sum = 0;
        for (std::int64_t i = first; i < last; ++i) {
          sum += damping_diagonal_[index(i)] * step_[index(i)] * step_[index(i)];
        }
        return sum;
      });
  record_.predicted_decrease = -slope - 0.5 * curvature - 0.5 * damped;
  record_.step_norm = std::sqrt(linalg::dot(step_.data(), step_.data(), unknowns, pool_));
}

void TrustRegion::evaluate_candidate() {
  const PhaseTimer timer(summary_.seconds.residual);
  objective_.retract(state_, step_.data(), candidate_);
  record_.candidate_cost = objective_.cost(candidate_);
  record_.relative_step =
      objective_.relative_step(state_, step_.data(), summary_.options.parameter_tolerance);
}

// A step is accepted when it lowers the cost. A NaN anywhere, or a model that promises nothing,
// fails every comparison and is a rejection.
void TrustRegion::judge() {
  if (step_valid_ && record_.predicted_decrease > 0) {
    record_.rho = (cost_ - record_.candidate_cost) / record_.predicted_decrease;
  }
  record_.accepted = record_.rho > 0;
  if (damping_) damping_->update(record_.rho);
  if (radius_) radius_->update(record_.rho, report_.on_boundary, report_.length);
  if (block_radius_) {
    block_radius_->update(record_.rho, report_.block_on_boundary, report_.block_length);
  }
  if (!record_.accepted) return;
  std::swap(state_, candidate_);
  cost_ = record_.candidate_cost;
}

void TrustRegion::end_iteration() {
  record_.seconds = seconds();
  summary_.iterations.push_back(record_);
  if (record_.accepted && record_.iteration > 0) ++summary_.accepted;
  const auto verdict = convergence_.test(record_, situation());
  const auto limit = convergence_.limit(record_);
  const bool asked = observer_ && observer_(record_) == Control::stop;
  if (!limit && !asked && rounding_is_suspect(verdict)) {
    widen_rows();
  } else if (verdict && loss_.is_final()) {
    stop(*verdict);
  } else if (limit) {
    stop(*limit);
  } else if (asked) {
    stop(Termination::stopped);
  } else {
    const double gain = (previous_cost_ - cost_) / previous_cost_;
    const bool moved = record_.accepted && record_.iteration > 0;
    if ((verdict || moved) && loss_.tighten(verdict ? 0 : gain)) tighten_loss();
  }
}

Convergence::Situation TrustRegion::situation() const {
  Convergence::Situation result;
  result.previous_cost = previous_cost_;
  if (damping_) result.next_damping = damping_->mu();
  if (radius_) result.next_radius = radius_->radius();
  result.promise = promise_;
  return result;
}

// The same state under a smaller scale: another cost, and another problem to linearise. What
// damping and radius learnt from failures under the old one does not bind it.
void TrustRegion::tighten_loss() {
  set_loss_scale(loss_.scale());
  convergence_.restart();
  start_globalisation();
  linearize();
}

void TrustRegion::set_loss_scale(double scale) {
  const PhaseTimer timer(summary_.seconds.residual);
  objective_.set_loss_scale(scale);
  cost_ = objective_.cost(state_);
}

void TrustRegion::stop(Termination termination) {
  stopped_ = true;
  summary_.termination = termination;
  summary_.message = Convergence::explain(termination, summary_);
  if (!loss_.is_final()) {  // start and end are comparable
    set_loss_scale(*summary_.options.loss_scale);
    if (termination != Termination::out_of_memory) linearize();
  }
  summary_.final_cost = cost_;
  summary_.options.precision = J_.precision();
  summary_.gradient_norm = record_.gradient_norm;
  summary_.seconds.total = seconds();
}

double TrustRegion::seconds() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

}  // namespace raybundle
