#include <raybundle/solver/convergence.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace raybundle {

Convergence::Convergence(const Options& options, std::int64_t residuals, double rounding)
    : options_(options), rounding_(rounding), residuals_(static_cast<double>(residuals)) {}

// Of a sum of so many squares; and of residuals r_i that are each rounded to some 5 epsilon of
// their observation u_i: |(5 epsilon u_i r_i)| for residuals of equal size, where rounding_ is
// 1/2 |(1000 epsilon u_i)|^2.
double Convergence::resolution(double cost) const {
  const double of_sum = std::numeric_limits<double>::epsilon() * std::sqrt(residuals_) * cost;
  return std::max(of_sum, 0.01 * std::sqrt(cost * rounding_ / residuals_));
}

std::optional<Termination> Convergence::test(const IterationRecord& record,
                                             const Situation& situation) {
  if (record.gradient_max <= options_.gradient_tolerance) return Termination::gradient_tolerance;
  if (record.cost <= rounding_) return Termination::function_tolerance;
  if (record.iteration == 0) return std::nullopt;
  return record.accepted ? test_accepted(record, situation) : test_rejected(record, situation);
}

std::optional<Termination> Convergence::limit(const IterationRecord& record) const {
  if (record.iteration >= options_.max_iterations) return Termination::max_iterations;
  if (record.seconds >= options_.time_limit) return Termination::time_limit;
  return std::nullopt;
}

// A step that something cut short is small for that reason and tells nothing of the minimum.
std::optional<Termination> Convergence::test_accepted(const IterationRecord& record,
                                                      const Situation& situation) {
  const bool shortened = failures_ > 0 || record.on_boundary || record.inner_capped;
  failures_ = 0;
  if (shortened) return std::nullopt;
  const double cost = situation.previous_cost;
  const double flat = options_.function_tolerance * cost;
  if (cost - record.cost <= flat && situation.promise <= flat) {
    return Termination::function_tolerance;
  }
  // Blockwise: one huge focal length would hide every other unknown in a norm of the whole state.
  const bool still = record.relative_step <= options_.parameter_tolerance;
  if (still && situation.promise <= std::max(flat, options_.parameter_tolerance * cost)) {
    return Termination::parameter_tolerance;
  }
  return std::nullopt;
}

std::optional<Termination> Convergence::test_rejected(const IterationRecord& record,
                                                      const Situation& situation) {
  ++failures_;
  // After failures the damping alone makes the model promise little: then only rounding excuses.
  const double tolerance = options_.function_tolerance * record.cost;
  const double rounding = resolution(record.cost);
  const double flat = failures_ == 1 ? std::max(tolerance, rounding) : rounding;
  const bool converged = record.step_norm > 0 && record.predicted_decrease <= flat &&
                         std::abs(record.candidate_cost - record.cost) <= flat &&
                         situation.promise <= std::max(flat, tolerance);
  if (converged) return Termination::function_tolerance;
  if (options_.max_damping && situation.next_damping > *options_.max_damping) {
    return Termination::damping_limit;
  }
  if (options_.min_radius && situation.next_radius < *options_.min_radius) {
    return Termination::radius_limit;
  }
  if (failures_ >= options_.max_consecutive_failures) return Termination::consecutive_failures;
  return std::nullopt;
}

std::string Convergence::explain(Termination termination, const Summary& summary) {
  const IterationRecord& last = summary.iterations.back();
  const Options& options = summary.options;
  std::ostringstream text;
  switch (termination) {
    case Termination::gradient_tolerance:
      text << "converged: the largest gradient entry " << last.gradient_max << " is at most "
           << options.gradient_tolerance;
      break;
    case Termination::function_tolerance:
      if (last.cost <= summary.rounding) {
        text << "converged: the observations are met to rounding";
      } else if (last.accepted) {
        text << "converged: the cost changes by no more than " << options.function_tolerance
             << " of its value";
      } else {
        text << "converged: the model promises no decrease that the cost can show";
      }
      break;
    case Termination::parameter_tolerance:
      text << "converged: the largest relative step of a block " << last.relative_step
           << " is at most " << options.parameter_tolerance;
      break;
    case Termination::max_iterations:
      text << "limit: " << options.max_iterations << " iterations";
      break;
    case Termination::time_limit:
      text << "limit: " << options.time_limit << " seconds";
      break;
    case Termination::stopped:
      text << "stopped by the observer";
      break;
    case Termination::damping_limit:
      text << "failed: no step lowers the cost, and the damping is at its limit "
           << options.max_damping.value_or(0);
      break;
    case Termination::radius_limit:
      text << "failed: no step lowers the cost, and the trust region is at its limit "
           << options.min_radius.value_or(0);
      break;
    case Termination::consecutive_failures:
      text << "failed: " << options.max_consecutive_failures << " rejected steps in a row";
      break;
    case Termination::bad_start:
      text << "failed: the cost or the gradient of the start is not finite";
      break;
    case Termination::out_of_memory:
      text << "failed: the system has no more memory";
      break;
  }
  return text.str();
}

}  // namespace raybundle
