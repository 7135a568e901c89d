#include <raybundle/models/objective.h>

#include <raybundle/models/error.h>
#include <raybundle/models/rotation.h>

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace raybundle {
namespace {

using linalg::index;

constexpr std::int64_t row_grain = 512;
/// Rows that a loss weights at a time, while they are in the first-level cache.
constexpr std::int64_t weighted_rows = 64;

int hub_size(Lens lens) { return lens == Lens::free ? 9 : 6; }

double norm(const double* x, int size) {
  double squares = 0;
  for (int i = 0; i < size; ++i) squares += x[i] * x[i];
  return std::sqrt(squares);
}

}  // namespace

Objective::Objective(const Problem& problem, PoseUpdate update, Lens lens, linalg::ThreadPool& pool,
                     const RobustLoss& loss)
    : update_(update),
      lens_(lens),
      loss_(loss),
      pool_(pool),
      kernels_(residual_kernels(update, lens)),
      fixed_camera_parameters_(problem.fixed_camera_parameters),
      fixed_points_(problem.fixed_points) {
  validate(problem);
  validate(loss);
  check_fixed();
  sort_rows(problem);
  layout_ = linalg::make_layout({2, hub_size(lens), Problem::point_size}, problem.camera_count(),
                                problem.point_count(), row_point_, row_camera_);
  frames_.resize(index(problem.camera_count()));
  constexpr double resolution = 1000 * std::numeric_limits<double>::epsilon();
  for (const double x : observed_) rounding_cost_ += 0.5 * resolution * resolution * x * x;
}

void Objective::check_fixed() const {
  if (update_ == PoseUpdate::global) return;
  constexpr unsigned rotation = 0b000111, translation = 0b111000;
  const auto whole = [](unsigned mask, unsigned part) {
    return (mask & part) == 0 || (mask & part) == part;
  };
  for (std::size_t c = 0; c < fixed_camera_parameters_.size(); ++c) {
    const unsigned mask = fixed_camera_parameters_[c];
    const bool holds = update_ == PoseUpdate::local
                           ? whole(mask, rotation) && whole(mask, translation)
                           : whole(mask, rotation | translation);
    if (holds) continue;
    throw InputError("problem", 0, "camera " + std::to_string(c) + " with a partly fixed pose",
                     update_ == PoseUpdate::local
                         ? "all or none of its rotation and of its translation fixed, or the "
                           "global pose update"
                         : "all or none of its pose fixed, or the global pose update");
  }
}

unsigned Objective::fixed_mask(std::int64_t camera) const {
  return fixed_camera_parameters_.empty() ? 0U : fixed_camera_parameters_[index(camera)];
}

// Rows by point, then camera; observations of the same pair keep their order.
void Objective::sort_rows(const Problem& problem) {
  const std::int64_t rows = problem.observation_count();
  std::vector<std::int64_t> next(index(problem.point_count() + 1), 0);
  for (const std::int32_t point : problem.observation_point) ++next[index(point) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  const std::vector<std::int64_t> begin = next;
  std::vector<std::int64_t> order(index(rows));
  for (std::int64_t k = 0; k < rows; ++k) {
    order[index(next[index(problem.observation_point[index(k)])]++)] = k;
  }
  const auto camera_of = [&](std::int64_t k) { return problem.observation_camera[index(k)]; };
  for (std::int64_t point = 0; point < problem.point_count(); ++point) {
    std::stable_sort(order.begin() + begin[index(point)], order.begin() + begin[index(point + 1)],
                     [&](auto a, auto b) { return camera_of(a) < camera_of(b); });
  }
  row_camera_.reserve(index(rows));
  row_point_.reserve(index(rows));
  observed_.reserve(index(2 * rows));
  for (const std::int64_t k : order) {
    row_camera_.push_back(camera_of(k));
    row_point_.push_back(problem.observation_point[index(k)]);
    observed_.push_back(problem.observations[index(2 * k)]);
    observed_.push_back(problem.observations[index(2 * k + 1)]);
  }
}

void Objective::update_frames(const State& state) {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const auto cameras = static_cast<std::int64_t>(frames_.size());
  linalg::parallel_for(pool_, cameras, 64, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t c = first; c < last; ++c) {
      const double* camera = state.cameras.data() + c * Problem::camera_size;
      CameraFrame& frame = frames_[index(c)];
      const so3::Vector3 phi = Eigen::Map<const so3::Vector3>(camera);
      Eigen::Map<RowMajor>(frame.R_cw) = so3::exp(phi);
      if (update_ == PoseUpdate::global) Eigen::Map<RowMajor>(frame.J_r) = so3::right_jacobian(phi);
      std::copy_n(camera + 3, 3, frame.t_cw);
      std::copy_n(camera + 6, 3, frame.lens);
    }
  });
}

ResidualInput Objective::input(const State& state) const {
  return {frames_.data(), state.points.data(), row_camera_.data(), row_point_.data(),
          observed_.data()};
}

void Objective::set_loss_scale(double scale) {
  RobustLoss loss = loss_;
  loss.scale = scale;
  validate(loss);
  loss_ = loss;
}

double Objective::robust_cost(const ResidualInput& in, std::int64_t first,
                              std::int64_t last) const {
  std::array<double, index(2 * weighted_rows)> residual;
  double sum = 0;
  for (std::int64_t row = first; row < last; row += weighted_rows) {
    const std::int64_t end = std::min(row + weighted_rows, last);
    kernels_.residuals(in, residual.data(), row, end);
    sum += robust_sum(loss_, residual.data(), end - row);
  }
  return 0.5 * sum;
}

double Objective::robust_linearize(const ResidualInput& in, const ResidualOutput& out,
                                   std::int64_t first, std::int64_t last) const {
  std::array<double, index(2 * weighted_rows)> factor;
  double sum = 0;
  for (std::int64_t row = first; row < last; row += weighted_rows) {
    const std::int64_t end = std::min(row + weighted_rows, last);
    const std::int64_t components = 2 * (end - row);
    kernels_.linearize(in, out, row, end);
    sum += robust_weights(loss_, out.residual + 2 * row, end - row, factor.data());
    scale_rows(factor.data(), components, 1, out.residual + 2 * row);
    scale_rows(factor.data(), components, layout_.hub_size, out.J_hub + 2 * row * layout_.hub_size);
    scale_rows(factor.data(), components, layout_.leaf_size,
               out.J_leaf + 2 * row * layout_.leaf_size);
  }
  return 0.5 * sum;
}

double Objective::cost(const State& state) {
  update_frames(state);
  const ResidualInput in = input(state);
  return linalg::parallel_sum(pool_, layout_.rows, row_grain,
                              [&](std::int64_t first, std::int64_t last) {
                                return loss_.kind == Loss::none ? kernels_.cost(in, first, last)
                                                                : robust_cost(in, first, last);
                              });
}

double Objective::linearize(const State& state, double* residual, linalg::BlockJacobian& J) {
  update_frames(state);
  const ResidualInput in = input(state);
  const ResidualOutput out = {residual, J.hub_blocks.data(), J.leaf_blocks.data()};
  return linalg::parallel_sum(
      pool_, layout_.rows, row_grain, [&](std::int64_t first, std::int64_t last) {
        const double sum = loss_.kind == Loss::none ? kernels_.linearize(in, out, first, last)
                                                    : robust_linearize(in, out, first, last);
        clear_fixed(first, last, J);
        return sum;
      });
}

// Unknowns that stay as they are have no derivative, hence no gradient and no step.
void Objective::clear_fixed(std::int64_t first, std::int64_t last, linalg::BlockJacobian& J) const {
  if (!fixed_points_.empty()) {
    for (std::int64_t row = first; row < last; ++row) {
      if (fixed_points_[index(row_point_[index(row)])] == 0) continue;
      std::fill_n(J.leaf_blocks.data() + row * 6, 6, 0.0);
    }
  }
  if (fixed_camera_parameters_.empty()) return;
  const int size = layout_.hub_size;
  for (std::int64_t row = first; row < last; ++row) {
    const unsigned mask = fixed_mask(row_camera_[index(row)]);
    for (int k = 0; mask != 0 && k < size; ++k) {
      if ((mask >> k & 1U) == 0) continue;
      J.hub_blocks[index(2 * row * size + k)] = 0;
      J.hub_blocks[index((2 * row + 1) * size + k)] = 0;
    }
  }
}

void Objective::retract(const State& state, const double* step, State& next) {
  const int size = layout_.hub_size;
  const std::int64_t cameras = layout_.hubs;
  linalg::parallel_for(pool_, cameras, 64, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t c = first; c < last; ++c) {
      const double* delta = step + c * size;
      const double* camera = state.cameras.data() + c * Problem::camera_size;
      double* moved = next.cameras.data() + c * Problem::camera_size;
      std::copy_n(camera, Problem::camera_size, moved);
      const bool moves = std::any_of(delta, delta + 6, [](double x) { return x != 0; });
      if (moves) retract_pose(update_, camera, delta, moved);
      for (int k = 6; k < size; ++k) moved[k] += delta[k];
      const unsigned mask = fixed_mask(c);
      for (int k = 0; mask != 0 && k < Problem::camera_size; ++k) {
        if ((mask >> k & 1U) != 0) moved[k] = camera[k];
      }
    }
  });
  const double* delta = step + layout_.offset(linalg::Side::leaves);
  const auto coordinates = static_cast<std::int64_t>(state.points.size());
  linalg::parallel_for(pool_, coordinates, 16384, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      const bool fixed = !fixed_points_.empty() && fixed_points_[index(i / 3)] != 0;
      next.points[index(i)] = fixed ? state.points[index(i)] : state.points[index(i)] + delta[i];
    }
  });
}

double Objective::relative_step(const State& state, const double* step, double tolerance) const {
  constexpr std::array camera_blocks = {3, 3, 1, 2};
  const std::size_t used = lens_ == Lens::free ? 4 : 2;
  const double* point_step = step + layout_.offset(linalg::Side::leaves);
  std::array<double, linalg::max_chunks> largest = {};
  const linalg::Chunks pieces = linalg::chunks(layout_.hubs + layout_.leaves, 4096);
  pool_.run(pieces.pieces, [&](std::int64_t piece) {
    double most = 0;
    const auto measure = [&](const double* block, const double* delta, int size) {
      most = std::max(most, norm(delta, size) / (norm(block, size) + tolerance));
    };
    for (std::int64_t b = pieces.begin(piece); b < pieces.end(piece); ++b) {
      if (b >= layout_.hubs) {
        const std::int64_t at = (b - layout_.hubs) * Problem::point_size;
        measure(state.points.data() + at, point_step + at, Problem::point_size);
        continue;
      }
      const double* block = state.cameras.data() + b * Problem::camera_size;
      const double* delta = step + b * layout_.hub_size;
      for (std::size_t k = 0; k < used; ++k) {
        measure(block, delta, camera_blocks[k]);
        block += camera_blocks[k];
        delta += camera_blocks[k];
      }
    }
    largest[index(piece)] = most;
  });
  return *std::max_element(largest.begin(), largest.end());
}

}  // namespace raybundle
