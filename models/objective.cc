#include <raybundle/models/objective.h>

#include <raybundle/models/error.h>
#include <raybundle/models/rays.h>
#include <raybundle/models/rotation.h>

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace raybundle {
namespace {

using linalg::index;
using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr std::int64_t row_grain = 512;
/// Rows that a loss weights at a time, while they are in the first-level cache.
constexpr std::int64_t weighted_rows = 64;

}  // namespace

Objective::Objective(const Problem& problem, const Formulation& formulation,
                     linalg::ThreadPool& pool, const RobustLoss& loss)
    : formulation_(formulation),
      loss_(loss),
      pool_(pool),
      kernels_(residual_kernels(is_anchored(formulation.points), formulation.pose_update,
                                sensor_of(formulation))),
      aspect_(problem.aspect),
      fixed_camera_parameters_(problem.fixed_camera_parameters),
      fixed_points_(problem.fixed_points) {
  validate(problem, pool);
  validate(loss);
  check_fixed();
  frames_.resize(index(problem.camera_count()));
  compile_layout(problem);
  rounding_cost_ = rounding_cost_of(problem);
  still_ = fixed_camera_parameters_;
  if (formulation.gauge == Gauge::fixed) hold_gauge(problem);
  if (is_anchored(formulation.points) && !fixed_points_.empty()) places_ = problem.points;
}

linalg::LayoutSize Objective::layout_size(const Problem& problem, const Formulation& formulation) {
  const Sensor sensor = sensor_of(formulation);
  const int anchors = formulation.points == PointModel::idp ? 1 : 2;
  return {.block = {residual_size(sensor), camera_unknowns(sensor), Problem::point_size},
          .hubs = problem.camera_count(),
          .leaves = problem.point_count(),
          .rows = problem.observation_count(),
          .anchors = is_anchored(formulation.points) ? anchors : 0};
}

double Objective::memory(const Problem& problem, const Formulation& formulation) {
  const linalg::LayoutSize n = layout_size(problem, formulation);
  const auto rows = static_cast<double>(n.rows);
  double bytes = linalg::BlockLayout::memory(n) + sizeof(CameraFrame) * static_cast<double>(n.hubs);
  if (!is_in_row_order(problem)) bytes += 16 * rows;
  if (formulation.objective == ObjectiveKind::ray) bytes += 24 * rows;
  if (n.anchored()) bytes += sizeof(Anchors) * static_cast<double>(n.leaves);
  return bytes;
}

void Objective::compile_layout(const Problem& problem) {
  const bool anchored = is_anchored(formulation_.points);
  const bool ray = formulation_.objective == ObjectiveKind::ray;
  ObservationRows rows(problem, pool_);
  if (!rows.observation.empty()) {
    sorted_pixels_ = in_row_order(rows, problem.observations, 2, pool_);
  }
  pixels_ = sorted_pixels_.empty() ? problem.observations.data() : sorted_pixels_.data();
  linalg::LargeVector<double> rays;
  if (ray || anchored) {
    rays = in_row_order(rows, ray ? observed_rays(problem) : apparent_rays(problem), 3, pool_);
  }
  layout_ = linalg::make_layout(
      layout_size(problem, formulation_).block, problem.camera_count(), problem.point_count(),
      {std::move(rows.point), std::move(rows.camera), std::move(rows.begin)}, pool_);
  rows_ = {layout_.row_hub(), layout_.row_leaf(), layout_.leaf_rows()};
  if (anchored) choose_all_anchors(problem, rays);
  if (!ray) return;
  rays_ = std::move(rays);
  if (formulation_.ray_weight == RayWeight::focal) weigh_rays(problem);
}

void Objective::weigh_rays(const Problem& problem) {
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    rays_[i] *= std::abs(problem.cameras[9 * index(rows_.camera[i / 3]) + 6]);
  }
}

double Objective::rounding_cost_of(const Problem& problem) const {
  constexpr double resolution = 1000 * std::numeric_limits<double>::epsilon();
  const bool of_lens = formulation_.ray_weight == RayWeight::pixel;
  const auto squares_of = [&](std::int64_t row) {
    if (formulation_.objective == ObjectiveKind::pixel) {
      const double* u = pixels_ + 2 * row;
      return u[0] * u[0] + u[1] * u[1];
    }
    const double f = of_lens ? problem.cameras[9 * index(rows_.camera[index(row)]) + 6] : 1;
    const double* ray = rays_.data() + 3 * row;
    return f * f * (ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
  };
  const double squares = linalg::parallel_sum(pool_, layout_.rows, row_grain,
                                              [&](std::int64_t first, std::int64_t last) {
                                                double sum = 0;
                                                for (; first < last; ++first) {
                                                  sum += squares_of(first);
                                                }
                                                return sum;
                                              });
  return 0.5 * resolution * resolution * squares;
}

void Objective::choose_all_anchors(const Problem& problem,
                                   const linalg::LargeVector<double>& rays) {
  const CameraPoses poses(problem.cameras);
  const SeenRays seen = poses.seen(rows_.camera, rays);
  const bool idp = formulation_.points == PointModel::idp;
  anchors_.resize(index(problem.point_count()));
  std::vector<linalg::LeafAnchors> of_leaves(anchors_.size());
  linalg::parallel_for(
      pool_, problem.point_count(), 64, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t i = first; i < last; ++i) {
          Anchors& chosen = anchors_[index(i)];
          chosen =
              choose_anchors(seen, {rows_.begin[index(i)], rows_.begin[index(i + 1)]}, idp).anchors;
          if (idp) chosen.associate = -1;
          of_leaves[index(i)] = {chosen.main, chosen.associate};
        }
      });
  linalg::anchor_leaves(layout_, of_leaves);
}

void Objective::check_fixed() const {
  if (formulation_.pose_update == PoseUpdate::global) return;
  constexpr unsigned rotation = 0b000111, translation = 0b111000;
  const auto whole = [](unsigned mask, unsigned part) {
    return (mask & part) == 0 || (mask & part) == part;
  };
  for (std::size_t c = 0; c < fixed_camera_parameters_.size(); ++c) {
    const unsigned mask = fixed_camera_parameters_[c];
    const bool holds = formulation_.pose_update == PoseUpdate::local
                           ? whole(mask, rotation) && whole(mask, translation)
                           : whole(mask, rotation | translation);
    if (holds) continue;
    throw InputError("problem", 0, "camera " + std::to_string(c) + " with a partly fixed pose",
                     formulation_.pose_update == PoseUpdate::local
                         ? "all or none of its rotation and of its translation fixed, or the "
                           "global pose update"
                         : "all or none of its pose fixed, or the global pose update");
  }
}

void Objective::hold_gauge(const Problem& problem) {
  constexpr unsigned pose = 0b111111;
  const auto holds = [](unsigned mask) { return (mask & pose) != 0; };
  if (std::any_of(fixed_camera_parameters_.begin(), fixed_camera_parameters_.end(), holds) ||
      std::any_of(fixed_points_.begin(), fixed_points_.end(), [](auto x) { return x != 0; })) {
    return;
  }
  update_frames({problem.cameras, {}});
  still_.resize(index(layout_.hubs), 0);
  std::int64_t first = -1;
  for (std::int64_t c = 0; c < layout_.hubs; ++c) {
    if (layout_.hub_side.begin[index(c)] == layout_.hub_side.begin[index(c + 1)]) continue;
    if (first < 0) {
      first = c;
      still_[index(c)] |= pose;
      continue;
    }
    const int component = scale_component(frames_[index(first)], frames_[index(c)]);
    if (component < 0) continue;  // at the same place
    still_[index(c)] = static_cast<std::uint16_t>(still_[index(c)] | 1U << (3 + component));
    return;
  }
}

// The largest component of the second centre's motion when everything grows from the first, in the
// axes of the pose update's translation: the world's for local, the camera's otherwise.
int Objective::scale_component(const CameraFrame& first, const CameraFrame& second) const {
  using so3::Vector3;
  Vector3 motion = Eigen::Map<const Vector3>(second.P) - Eigen::Map<const Vector3>(first.P);
  if (formulation_.pose_update != PoseUpdate::local) {
    motion = Eigen::Map<const RowMajor>(second.R_cw) * motion;
  }
  Eigen::Index component = 0;
  const double size = Eigen::Map<const Vector3>(second.P).cwiseAbs().maxCoeff();
  return motion.cwiseAbs().maxCoeff(&component) > 1e-12 * size ? static_cast<int>(component) : -1;
}

unsigned Objective::fixed_mask(std::int64_t camera) const {
  return fixed_camera_parameters_.empty() ? 0U : fixed_camera_parameters_[index(camera)];
}

void Objective::update_frames(const State& state) {
  const auto cameras = static_cast<std::int64_t>(frames_.size());
  linalg::parallel_for(pool_, cameras, 64, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t c = first; c < last; ++c) {
      const double* camera = state.cameras.data() + c * Problem::camera_size;
      CameraFrame& frame = frames_[index(c)];
      const so3::Vector3 phi = Eigen::Map<const so3::Vector3>(camera);
      const so3::Matrix3 R_cw = so3::exp(phi);
      Eigen::Map<RowMajor>(frame.R_cw) = R_cw;
      if (formulation_.pose_update == PoseUpdate::global) {
        Eigen::Map<RowMajor>(frame.J_r) = so3::right_jacobian(phi);
      }
      std::copy_n(camera + 3, 3, frame.t_cw);
      std::copy_n(camera + 6, 3, frame.lens);
      Eigen::Map<so3::Vector3>(frame.P) =
          -(R_cw.transpose() * Eigen::Map<const so3::Vector3>(camera + 3));
      frame.aspect = aspect_;
    }
  });
}

ResidualInput Objective::input(const State& state) const {
  const bool ray = formulation_.objective == ObjectiveKind::ray;
  return {frames_.data(),     state.points.data(),           rows_.camera.data(),
          rows_.point.data(), ray ? rays_.data() : pixels_,  formulation_.points,
          anchors_.data(),    layout_.anchorage.begin.data()};
}

void Objective::set_loss_scale(double scale) {
  RobustLoss loss = loss_;
  loss.scale = scale;
  validate(loss);
  loss_ = loss;
}

double Objective::cost_of(const ResidualInput& in, std::int64_t first, std::int64_t last) const {
  return loss_.kind == Loss::none ? kernels_.cost(in, first, last) : robust_cost(in, first, last);
}

double Objective::robust_cost(const ResidualInput& in, std::int64_t first,
                              std::int64_t last) const {
  std::array<double, index(3 * weighted_rows)> residual;
  double sum = 0;
  for (std::int64_t row = first; row < last; row += weighted_rows) {
    const std::int64_t end = std::min(row + weighted_rows, last);
    kernels_.residuals(in, residual.data(), row, end);
    sum += robust_sum(loss_, residual.data(), end - row, layout_.row_size);
  }
  return 0.5 * sum;
}

// The rows of a tile, weighted by the loss, and their cost.
double Objective::evaluate(const ResidualInput& in, const linalg::RowTile& tile, double* Z) const {
  const int size = layout_.row_size;
  const std::int64_t before = size * tile.first;  // kernels count rows from the very first
  const ResidualOutput out = {tile.residual - before, tile.J_hub - before * layout_.hub_size,
                              tile.J_leaf - before * layout_.leaf_size, Z};
  const double plain = kernels_.linearize(in, out, tile.first, tile.last);
  if (loss_.kind == Loss::none) return plain;
  std::array<double, index(3 * linalg::tile_rows)> factor;
  const double sum =
      robust_weights(loss_, tile.residual, tile.last - tile.first, size, factor.data());
  const std::int64_t components = size * (tile.last - tile.first);
  scale_rows(factor.data(), components, 1, tile.residual);
  scale_rows(factor.data(), components, layout_.leaf_size, tile.J_leaf);
  scale_rows(factor.data(), components, layout_.hub_size, tile.J_hub);
  return 0.5 * sum;
}

double Objective::cost(const State& state) {
  update_frames(state);
  const ResidualInput in = input(state);
  return linalg::parallel_sum(
      pool_, layout_.rows, row_grain,
      [&](std::int64_t first, std::int64_t last) { return cost_of(in, first, last); });
}

double Objective::linearize(const State& state, linalg::BlockJacobian& J,
                            linalg::NormalEquations& normal, double* residual) {
  update_frames(state);
  const ResidualInput in = input(state);
  return normal.form(J, pool_, [&](const linalg::RowTile& tile) {
    const double cost = evaluate(in, tile, J.anchor_blocks.data());
    clear_fixed(tile);
    clear_fixed_anchors(tile, J);
    if (residual != nullptr) {
      std::copy_n(tile.residual, (tile.last - tile.first) * layout_.row_size,
                  residual + tile.first * layout_.row_size);
    }
    return cost;
  });
}

double Objective::pixel_cost(const State& state) {
  if (formulation_.objective == ObjectiveKind::pixel && loss_.kind == Loss::none) {
    return cost(state);
  }
  update_frames(state);
  ResidualInput in = input(state);
  in.observed = pixels_;
  const ResidualKernels& kernels =
      residual_kernels(is_anchored(formulation_.points), formulation_.pose_update, Sensor::pixel);
  return linalg::parallel_sum(
      pool_, layout_.rows, row_grain,
      [&](std::int64_t first, std::int64_t last) { return kernels.cost(in, first, last); });
}

// Unknowns that stay as they are have no derivative, hence no gradient and no step.
void Objective::clear_fixed(const linalg::RowTile& tile) const {
  const int of_leaf = layout_.row_size * layout_.leaf_size;
  const int of_hub = layout_.row_size * layout_.hub_size;
  for (std::int64_t row = tile.first; row < tile.last && !fixed_points_.empty(); ++row) {
    if (!is_fixed(rows_.point[index(row)])) continue;
    std::fill_n(tile.J_leaf + (row - tile.first) * of_leaf, of_leaf, 0.0);
  }
  for (std::int64_t row = tile.first; row < tile.last && !still_.empty(); ++row) {
    clear_columns(still_[index(rows_.camera[index(row)])], layout_.row_size,
                  tile.J_hub + (row - tile.first) * of_hub);
  }
}

// The same of the anchors of points whose first row is in the tile: a camera that stays moves no
// point, and a point that stays is moved by none.
void Objective::clear_fixed_anchors(const linalg::RowTile& tile, linalg::BlockJacobian& J) const {
  if (!layout_.anchored() || (still_.empty() && fixed_points_.empty())) return;
  const linalg::Anchorage& anchorage = layout_.anchorage;
  const int size = layout_.leaf_size * layout_.hub_size;
  for (std::int64_t row = tile.first; row < tile.last; ++row) {
    const std::int32_t i = rows_.point[index(row)];
    if (row != rows_.begin[index(i)]) continue;
    for (std::int64_t k = anchorage.begin[index(i)]; k < anchorage.begin[index(i + 1)]; ++k) {
      double* Z = J.anchor_blocks.data() + k * size;
      const std::int32_t camera = layout_.hub_side.block[index(anchorage.coupling[index(k)])];
      if (is_fixed(i)) {
        std::fill_n(Z, size, 0.0);
      } else if (!still_.empty()) {
        clear_columns(still_[index(camera)], layout_.leaf_size, Z);
      }
    }
  }
}

void Objective::clear_columns(unsigned mask, int rows, double* block) const {
  for (int k = 0; mask != 0 && k < layout_.hub_size; ++k) {
    if ((mask >> k & 1U) == 0) continue;
    for (int i = 0; i < rows; ++i) block[i * layout_.hub_size + k] = 0;
  }
}

}  // namespace raybundle
