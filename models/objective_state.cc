// States of an Objective: from and to a Problem, and moved by a step.

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/rays.h>

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace raybundle {
namespace {

using linalg::index;

double norm(const double* x, int size) {
  double squares = 0;
  for (int i = 0; i < size; ++i) squares += x[i] * x[i];
  return std::sqrt(squares);
}

}  // namespace

// Calls place(i, stored numbers) for the points that somebody observes; others have no anchors, and
// keep what is there.
template <class Place>
void Objective::place_points(State& state, Place&& place) const {
  const int stored = stored_size(formulation_.points);
  state.points.resize(index(layout_.leaves * stored));
  linalg::parallel_for(pool_, layout_.leaves, 256, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      if (rows_.begin[index(i)] < rows_.begin[index(i + 1)]) {
        place(i, state.points.data() + i * stored);
      }
    }
  });
}

// The main anchor sees the direction of a point itself, whichever side that is; of the others most
// decide. Of idp, and of a point that has no associate, all have one side.
PointSides Objective::sides(std::int64_t i, const double* X, const CameraPoses& poses) const {
  using Map3 = Eigen::Map<const Eigen::Vector3d>;
  const Anchors& anchors = anchors_[index(i)];
  PointSides result;
  std::int64_t balance = 0;
  for (std::int64_t row = rows_.begin[index(i)]; row < rows_.begin[index(i + 1)]; ++row) {
    const std::int32_t camera = rows_.camera[index(row)];
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R_cw(poses.R_cw(camera));
    const double along = Map3(rays_.data() + 3 * row).dot(R_cw * (Map3(X) - Map3(poses.P(camera))));
    const bool alone = camera == anchors.main && anchors.associate >= 0;
    if (alone && along < 0) result.main = -1;
    if (!alone) balance += along < 0 ? -1 : 1;
  }
  if (balance < 0) result.others = -1;
  return result;
}

// Pixels do not tell on which side of its cameras a point is, rays do. A fixed point stays put.
void Objective::place_in_world(std::int64_t i, const double* X, const CameraPoses& poses,
                               double* stored) const {
  const bool as_seen = !rays_.empty() && !is_fixed(i);
  from_world(formulation_.points, X, poses.of(anchors_[index(i)]),
             as_seen ? sides(i, X, poses) : PointSides{}, stored);
}

State Objective::state_of(const Problem& problem) const {
  State state = {problem.cameras, {}};
  if (!is_anchored(formulation_.points)) {
    state.points.assign(problem.points.begin(), problem.points.end());
    return state;
  }
  const CameraPoses poses(problem.cameras);
  place_points(state, [&](std::int64_t i, double* stored) {
    place_in_world(i, problem.points.data() + 3 * i, poses, stored);
  });
  return state;
}

// xyz and idp too are placed by the pair of best parallax; fixed points stay.
State Objective::state_from_rays(const Problem& problem) const {
  State state = state_of(problem);
  const CameraPoses poses(problem.cameras);
  const auto rays = in_row_order(ObservationRows(problem, pool_), apparent_rays(problem), 3, pool_);
  const SeenRays seen = poses.seen(rows_.camera, rays);
  const bool idp = formulation_.points == PointModel::idp;
  place_points(state, [&](std::int64_t i, double* stored) {
    if (is_fixed(i)) return;
    const Track track = {rows_.begin[index(i)], rows_.begin[index(i + 1)]};
    const AnchorRows best = choose_anchors(seen, track, idp);
    const std::int32_t associate = best.anchors.associate;
    AnchorRays ray = {rays.data() + 3 * best.main_row, nullptr, nullptr};
    if (associate >= 0) {
      ray.ray_associate = rays.data() + 3 * best.associate_row;
      ray.R_cw_associate = poses.R_cw(associate);
    }
    from_rays(formulation_.points, ray, poses.of(best.anchors), stored);
  });
  return state;
}

Problem with_points_from_rays(Problem problem, PointModel points) {
  linalg::ThreadPool pool(1);
  const Objective objective(problem, {.lens = Lens::fixed, .points = points}, pool);
  objective.write(objective.state_from_rays(problem), problem);
  return problem;
}

// Fixed points stay where they are in the world, wherever their anchors went.
void Objective::hold_points(State& state) const {
  if (fixed_points_.empty()) return;
  if (!is_anchored(formulation_.points)) return;
  const CameraPoses poses(state.cameras);
  place_points(state, [&](std::int64_t i, double* stored) {
    if (is_fixed(i)) place_in_world(i, places_.data() + 3 * i, poses, stored);
  });
}

void Objective::write(State state, Problem& problem) const {
  if (!is_anchored(formulation_.points)) {
    problem.points.assign(state.points.begin(), state.points.end());
  } else {
    const CameraPoses poses(state.cameras);
    const int stored = stored_size(formulation_.points);
    for (std::int64_t i = 0; i < layout_.leaves; ++i) {
      if (is_fixed(i) || anchors_[index(i)].main < 0) continue;
      to_world(formulation_.points, state.points.data() + i * stored, poses.of(anchors_[index(i)]),
               problem.points.data() + 3 * i);
    }
  }
  problem.cameras = std::move(state.cameras);
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
      if (moves) retract_pose(formulation_.pose_update, camera, delta, moved);
      for (int k = 6; k < size; ++k) moved[k] += delta[k];
      const unsigned mask = fixed_mask(c);
      for (int k = 0; mask != 0 && k < Problem::camera_size; ++k) {
        if ((mask >> k & 1U) != 0) moved[k] = camera[k];
      }
    }
  });
  const double* delta = step + layout_.offset(linalg::Side::leaves);
  const int stored = stored_size(formulation_.points);
  linalg::parallel_for(pool_, layout_.leaves, 4096, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      const double* point = state.points.data() + i * stored;
      double* moved = next.points.data() + i * stored;
      if (is_fixed(i)) {
        std::copy_n(point, stored, moved);
      } else {
        retract_point(formulation_.points, point, delta + 3 * i, moved);
      }
    }
  });
  hold_points(next);
}

std::int64_t Objective::hold_worse_points(const State& state, double* step, State& scratch) {
  retract(state, step, scratch);
  update_frames(scratch);
  const ResidualInput moved = input(scratch);
  ResidualInput held = moved;
  held.points = state.points.data();
  double* delta = step + layout_.offset(linalg::Side::leaves);
  std::array<std::int64_t, linalg::max_chunks> counts = {};
  const linalg::Chunks pieces = linalg::chunks(layout_.leaves, 256);
  pool_.run(pieces.pieces, [&](std::int64_t piece) {
    for (std::int64_t i = pieces.begin(piece); i < pieces.end(piece); ++i) {
      const std::int64_t first = rows_.begin[index(i)], last = rows_.begin[index(i + 1)];
      if (first == last || is_fixed(i)) continue;
      if (cost_of(moved, first, last) <= cost_of(held, first, last)) continue;  // not so a NaN
      std::fill_n(delta + 3 * i, Problem::point_size, 0.0);
      ++counts[index(piece)];
    }
  });
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

double Objective::relative_step(const State& state, const double* step, double tolerance) const {
  constexpr std::array camera_blocks = {3, 3, 1, 2};
  const int stored = stored_size(formulation_.points);
  const std::size_t used = formulation_.lens == Lens::free ? 4 : 2;
  const double* point_step = step + layout_.offset(linalg::Side::leaves);
  std::array<double, linalg::max_chunks> largest = {};
  const linalg::Chunks pieces = linalg::chunks(layout_.hubs + layout_.leaves, 4096);
  pool_.run(pieces.pieces, [&](std::int64_t piece) {
    double most = 0;
    const auto measure = [&](const double* block, int numbers, const double* delta, int size) {
      most = std::max(most, norm(delta, size) / (norm(block, numbers) + tolerance));
    };
    for (std::int64_t b = pieces.begin(piece); b < pieces.end(piece); ++b) {
      if (b >= layout_.hubs) {
        const std::int64_t i = b - layout_.hubs;
        measure(state.points.data() + i * stored, stored, point_step + i * Problem::point_size,
                Problem::point_size);
        continue;
      }
      const double* block = state.cameras.data() + b * Problem::camera_size;
      const double* delta = step + b * layout_.hub_size;
      for (std::size_t k = 0; k < used; ++k) {
        measure(block, camera_blocks[k], delta, camera_blocks[k]);
        block += camera_blocks[k];
        delta += camera_blocks[k];
      }
    }
    largest[index(piece)] = most;
  });
  return *std::max_element(largest.begin(), largest.end());
}

}  // namespace raybundle
