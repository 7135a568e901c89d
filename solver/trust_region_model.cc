// The model of a TrustRegion at its state: the linearisation, the matrices that go with it, and
// what it promises.

#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/vector.h>
#include <raybundle/models/camera_modes.h>
#include <raybundle/solver/phase_timer.h>
#include <raybundle/solver/trust_region.h>

#include <cmath>

namespace raybundle {

using linalg::index;

void TrustRegion::linearize() {
  const PhaseTimer timer(summary_.seconds.jacobian);
  // The sum it returns is rounded differently; costs that are compared come from one function.
  static_cast<void>(objective_.linearize(state_, J_, normal_));
  fill_matrices();
  fill_modes();
  relinearised_ = true;
  const std::int64_t unknowns = free_unknowns();
  const double* g = normal_.gradient.data();
  record_.cost = cost_;
  if (objective_.formulation().objective != ObjectiveKind::pixel) {
    record_.pixel_cost = objective_.pixel_cost(state_);
  }
  record_.gradient_norm = std::sqrt(linalg::dot(g, g, unknowns, pool_));
  record_.gradient_max = linalg::largest_magnitude(g, unknowns, pool_);
  if (forcing_) forcing_->linearized(record_.gradient_norm);
  promise_ = free_promise();
}

void TrustRegion::diagnose() {
  if (!diagnoser_) return;
  const PhaseTimer timer(summary_.seconds.diagnosis);
  record_.diagnosis = diagnoser_->measure({&J_, &normal_});
}

// 1/2 g^T diag(H)^-1 g / lambda, where lambda bounds the largest eigenvalue of H scaled to a unit
// diagonal: a row feels so many unknowns, those of anchors too (Cauchy-Schwarz).
double TrustRegion::free_promise() const {
  const linalg::BlockLayout& layout = objective_.layout();
  const PointModel points = objective_.formulation().points;
  const int cameras = !is_anchored(points) ? 1 : (points == PointModel::idp ? 2 : 3);
  return 0.5 * normal_.scaled_gradient_squares(free_unknowns(), pool_) /
         (cameras * layout.hub_size + layout.leaf_size);
}

// Only diag(H) changes from one linearisation to the next.
void TrustRegion::fill_matrices() {
  const Options& options = summary_.options;
  const auto due = [](DiagonalMatrix kind, const linalg::LargeVector<double>& matrix) {
    return is_of_h(kind) || matrix.empty();
  };
  if (damping_ && due(*options.damping_matrix, damping_matrix_)) {
    fill_diagonal(*options.damping_matrix, increments_, options.points, normal_, damping_matrix_,
                  pool_);
  }
  const DiagonalMatrix scaling = options.scaling.value_or(DiagonalMatrix::identity);
  if (scaling == DiagonalMatrix::identity || !due(scaling, inverse_scaling_)) return;
  fill_diagonal(scaling, increments_, options.points, normal_, inverse_scaling_, pool_);
  linalg::for_entries(
      static_cast<std::int64_t>(inverse_scaling_.size()), pool_,
      [&](std::size_t i) { inverse_scaling_[i] = 1 / std::sqrt(inverse_scaling_[i]); });
}

void TrustRegion::fill_modes() {
  if (!has_coarse_space(summary_.options)) return;
  const linalg::BlockLayout& layout = objective_.layout();
  hub_modes_.resize(index(layout.size(linalg::Side::hubs) * linalg::coarse_modes(layout.hub_size)));
  camera_modes(objective_.formulation().pose_update, state_.cameras, layout.hub_size,
               hub_modes_.data());
}

void TrustRegion::fill_damping() {
  if (!damping_) return;  // and the diagonal stays 0
  const double mu = damping_->mu();
  linalg::for_entries(static_cast<std::int64_t>(damping_diagonal_.size()), pool_,
                      [&](std::size_t i) { damping_diagonal_[i] = mu * damping_matrix_[i]; });
  if (!points_stay()) return;
  // Held by much more than their own curvature, and by so little that nothing is lost to rounding
  // where their anchors move them.
  constexpr double much = 1e6;
  const std::int64_t cameras = objective_.layout().size(linalg::Side::hubs);
  linalg::for_entries(objective_.layout().size(linalg::Side::leaves), pool_, [&](std::size_t i) {
    const std::int64_t unknown = cameras + static_cast<std::int64_t>(i);
    damping_diagonal_[index(unknown)] += much * normal_.diagonal_entry(unknown);
  });
}

// What is left of their steps.
void TrustRegion::hold_points() {
  std::fill(step_.begin() + objective_.layout().size(linalg::Side::hubs), step_.end(), 0.0);
  record_.points_held = objective_.layout().leaves;
}

// Those of the cameras come first.
std::int64_t TrustRegion::free_unknowns() const {
  return points_stay() ? objective_.layout().size(linalg::Side::hubs)
                       : objective_.layout().unknowns();
}

// The gradient and the cost are exact, whatever rows are rounded to: where steps promise a decrease
// that none of them brings, or cannot be computed, the model may be what is wrong.
bool TrustRegion::rounding_is_suspect(const std::optional<Termination>& verdict) const {
  if (summary_.options.precision || J_.precision() == Precision::double_precision) return false;
  const bool failed = verdict && outcome(*verdict) == Outcome::failed;
  if (!failed && (record_.iteration == 0 || report_.solved)) return false;
  const double more = widening_memory();
  return more < linalg::available_memory() &&
         more < summary_.options.memory_limit - linalg::resident_memory();
}

// What rows take more in double precision.
double TrustRegion::widening_memory() const {
  const linalg::BlockLayout& layout = objective_.layout();
  return 4.0 * static_cast<double>(layout.residuals()) * (layout.hub_size + layout.leaf_size);
}

// Once, and with it a fresh start of what failures taught.
void TrustRegion::widen_rows() {
  J_.set_precision(Precision::double_precision);
  summary_.widened_at = record_.iteration;
  convergence_.restart();
  start_globalisation();
  linearize();
}

}  // namespace raybundle
