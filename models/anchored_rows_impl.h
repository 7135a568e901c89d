// Rows of anchored points: each touches the camera that observes and the point, and feels the
// anchors through the point. The derivatives by a pose are formed as those by its centre P and by a
// small turn of its axes in the world, R_wc <- Exp(turn) R_wc, and then carried over to the
// unknowns of the pose update. Of some rows at a time the points come first, one by one, then the
// rows.

#pragma once

#include <raybundle/models/anchored_point_impl.h>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

template <class T>
struct PoseOf {
  const T* R_cw;
  const T* J_r;
  const T* P;
};

// From the derivatives by centre and turn to those by the step of a pose (models/pose.h):
//   local   turn = -dphi,      dP = P x dphi - dt
//   global  turn = -J_r dphi,  dP = P x J_r dphi - R_wc dt
//   se3     turn = -R_wc dphi, dP = -R_wc dt
template <PoseUpdate Update, class T>
[[gnu::always_inline]] inline void pose_row(const PoseOf<T>& pose, const T* by_centre,
                                            const T* by_turn, T* J) {
  if constexpr (Update == PoseUpdate::se3) {
    matrix_times(pose.R_cw, by_turn, J);
    matrix_times(pose.R_cw, by_centre, J + 3);
    for (int i = 0; i < 6; ++i) J[i] = -J[i];
  } else {
    T turn[3];
    cross(by_centre, pose.P, turn);
    for (int i = 0; i < 3; ++i) turn[i] -= by_turn[i];
    if constexpr (Update == PoseUpdate::local) {
      for (int i = 0; i < 3; ++i) J[i] = turn[i];
      for (int i = 0; i < 3; ++i) J[3 + i] = -by_centre[i];
    } else {
      row_times_matrix(turn, pose.J_r, J);
      matrix_times(pose.R_cw, by_centre, J + 3);
      for (int i = 3; i < 6; ++i) J[i] = -J[i];
    }
  }
}

// The points of a piece of consecutive rows.
class PointsOfRows {
 public:
  // Where a piece that begins at row `first` of a range ends: the points stay in the first-level
  // cache, and no piece but the only one is shorter than a vector.
  static Index end_of(Index first, Index last) {
    return last - first < most + lanes ? last : first + most;
  }

  // Calls use(point, effect) with those whose first row is among [first, last), and effects where
  // derivatives are asked for.
  template <bool derivatives, class Use>
  void prepare(const ResidualInput& in, Index first, Index last, Use&& use) {
    const SeenPoint** seen = seen_ + lanes;
    int slot = 0;
    if (in.row_point[first] == held_) {
      points_[0] = points_[held_slot_];
    } else {
      slot = -1;
    }
    for (Index row = first; row < last; ++row) {
      const std::int32_t at = in.row_point[row];
      if (slot < 0 || at != held_) {
        AnchorEffect effect[2];
        held_ = at;
        RAYBUNDLE_ISA::prepare<derivatives>(in, at, points_[++slot], effect);
        if (row == 0 || in.row_point[row - 1] != at) use(at, effect);
      }
      const bool is_main = in.row_camera[row] == in.anchors[at].main;
      seen[row - first] = is_main ? &points_[slot].main : &points_[slot].others;
    }
    held_slot_ = slot;
    for (int i = 0; i < lanes; ++i) seen_[i] = seen[0];
  }

  // That of the row at a place of the piece. Those before the first are as that one.
  const SeenPoint* seen(Index place) const { return seen_[lanes + place]; }

 private:
  static constexpr Index most = 32;

  AnchoredPoint points_[most + lanes];
  const SeenPoint* seen_[lanes + most + lanes];
  std::int32_t held_ = -1;  // the point of the last row
  int held_slot_ = 0;
};

template <Sensor of>
struct ObservedAnchored {
  static constexpr Sensor sensor = of;
  static constexpr int R = residual_size(sensor);

  CameraLanes camera;
  Lanes point[17];  // the numbers of SeenPoint
  Lanes offset[3];  // P_m - P
  Lanes D[3];       // the ray from the observer in the world
  Lanes X_c[3];     // and the same in its frame
  Lanes observed[R];

  template <bool derivatives, bool with_J_r>
  [[gnu::always_inline]] void load(const ResidualInput& in, const PointsOfRows& points, Index place,
                                   Index row) {
    load_cameras<with_J_r, true>(in.cameras, in.row_camera + row, camera);
    const double* numbers[lanes];
    for (int i = 0; i < lanes; ++i) numbers[i] = points.seen(place + i)->G;
    load_columns<derivatives ? 17 : 8>(numbers, point);
    load_rows<R>(in.observed + R * row, observed);
    const Lanes *G = point, *P_m = point + 4;
    for (int i = 0; i < 3; ++i) {
      offset[i] = P_m[i] - camera.P[i];
      D[i] = G[i] + s() * offset[i];
    }
    matrix_times(camera.R_cw(), D, X_c);
  }

  template <PoseUpdate Update>
  [[gnu::always_inline]] void derive(const Lanes* a, Lanes* J_leaf, Lanes* J_pose) const {
    Lanes b[3], by_centre[3], by_turn[3];  // b: by D
    row_times_matrix(a, camera.R_cw(), b);
    const Lanes s_first = point[7], *G_leaf = point + 8;
    for (int k = 0; k < 3; ++k) J_leaf[k] = dot(b, G_leaf + 3 * k);
    J_leaf[0] += s_first * dot(b, offset);
    for (int k = 0; k < 3; ++k) by_centre[k] = -s() * b[k];
    cross(b, D, by_turn);
    pose_row<Update, Lanes>({camera.R_cw(), camera.J_r, camera.P}, by_centre, by_turn, J_pose);
  }

  Lanes s() const { return point[3]; }
};

template <Sensor sensor>
struct AnchoredRows {
  using Observed = ObservedAnchored<sensor>;
  static constexpr int hub_size = camera_unknowns(sensor);

  // Calls piece(points, first, last) for pieces of the range, and use as prepare() does; returns
  // the sum over pieces.
  template <bool derivatives, class Use, class Piece>
  static double in_pieces(const ResidualInput& in, Index first, Index last, Use&& use,
                          Piece&& piece) {
    PointsOfRows points;
    double sum = 0;
    while (first < last) {
      const Index end = PointsOfRows::end_of(first, last);
      points.template prepare<derivatives>(in, first, end, use);
      sum += piece(points, first, end);
      first = end;
    }
    return sum;
  }

  static double cost(const ResidualInput& in, Index first, Index last) {
    const auto piece = [&](const PointsOfRows& points, Index row, Index row_end) {
      return in_vectors<sensor>(in, row, row_end, [&](const auto& rows, Index begin, Index end) {
        return vectors_cost<Observed>(rows, points, begin, end);
      });
    };
    return in_pieces<false>(
        in, first, last, [](Index, const AnchorEffect*) {}, piece);
  }

  static void residuals(const ResidualInput& in, double* residual, Index first, Index last) {
    const ResidualOutput out = {residual - Observed::R * first, nullptr, nullptr, nullptr};
    const auto piece = [&](const PointsOfRows& points, Index row, Index row_end) {
      return in_vectors<sensor>(in, out, row, row_end,
                                [&](const auto& rows, const auto& to, Index begin, Index end) {
                                  return vectors_residuals<Observed>(rows, points, to, begin, end);
                                });
    };
    in_pieces<false>(
        in, first, last, [](Index, const AnchorEffect*) {}, piece);
  }

  template <PoseUpdate Update>
  static void write_effect(const CameraFrame& camera, const AnchorEffect& effect, double* Z) {
    const PoseOf<double> pose = {camera.R_cw, camera.J_r, camera.P};
    for (int i = 0; i < 3; ++i) {
      pose_row<Update>(pose, effect.by_centre[i], effect.by_turn[i], Z + i * hub_size);
      for (int k = 6; k < hub_size; ++k) Z[i * hub_size + k] = 0;
    }
  }

  template <PoseUpdate Update>
  static double linearize(const ResidualInput& in, const ResidualOutput& out, Index first,
                          Index last) {
    const auto write_effects = [&](Index at, const AnchorEffect* effect) {
      const Anchors& anchors = in.anchors[at];
      double* Z = out.Z + in.first_anchor[at] * 3 * hub_size;
      write_effect<Update>(in.cameras[anchors.main], effect[0], Z);
      if (anchors.associate < 0) return;
      write_effect<Update>(in.cameras[anchors.associate], effect[1], Z + 3 * hub_size);
    };
    const auto piece = [&](const PointsOfRows& points, Index row, Index row_end) {
      return in_vectors<sensor>(
          in, out, row, row_end, [&](const auto& rows, const auto& to, Index begin, Index end) {
            return vectors_linearize<Observed, Update>(rows, points, to, begin, end);
          });
    };
    return in_pieces<true>(in, first, last, write_effects, piece);
  }
};

}  // namespace
}  // namespace raybundle::RAYBUNDLE_ISA
