// How residual kernels go through rows: as many at a time as a vector has lanes. What differs
// between descriptions of points is an Observed, which is what the rows in the lanes are about:
//   load<derivatives, with_J_r>(in, points, place, row)   gets it, of rows `row` and on, which
//     have the places `place` and on among those that `points` knows
//   camera, X_c, observed                                 are what the sensor sees
//   derive<Update>(a, J_leaf, J_pose)                     the derivatives of one residual by the
//     point and the pose, with a = its gradient by X_c

#pragma once

#include <raybundle/models/sensor_impl.h>

#include <cstddef>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

// The cameras of the rows in the lanes: each number of CameraFrame that a kernel reads.
struct CameraLanes {
  Lanes common[16];
  Lanes J_r[9];
  Lanes P[3];

  const Lanes* R_cw() const { return common; }
  const Lanes* t_cw() const { return common + 9; }
  const Lanes* lens() const { return common + 12; }
  Lanes aspect() const { return common[15]; }
};
static_assert(offsetof(CameraFrame, R_cw) == 0 && offsetof(CameraFrame, t_cw) == 9 * 8 &&
              offsetof(CameraFrame, lens) == 12 * 8 && offsetof(CameraFrame, aspect) == 15 * 8);

template <bool with_J_r, bool with_P>
[[gnu::always_inline]] inline void load_cameras(const CameraFrame* cameras,
                                                const std::int32_t* row_camera, CameraLanes& out) {
  const double *common[lanes], *J_r[lanes], *P[lanes];
  for (int i = 0; i < lanes; ++i) {
    const CameraFrame& camera = cameras[row_camera[i]];
    common[i] = camera.R_cw;
    J_r[i] = camera.J_r;
    P[i] = camera.P;
  }
  load_columns<16>(common, out.common);
  if constexpr (with_J_r) load_columns<9>(J_r, out.J_r);
  if constexpr (with_P) load_columns<3>(P, out.P);
}

// The residual, and with A and L its derivatives (sensor_impl.h).
template <class Observed, class... Derivatives>
[[gnu::always_inline]] inline void measure(const Observed& at, Lanes* r, Derivatives... A_and_L) {
  Measure<Observed::sensor, Lanes>::residual(at.camera.lens(), at.camera.aspect(), at.X_c,
                                             at.observed, r, A_and_L...);
}

// What a range that is shorter than a vector reads, as the last rows of a vector whose other lanes
// repeat the first one: by the same code, so that a row has the same bits wherever it stands.
template <Sensor sensor>
struct ShortInput {
  static constexpr int R = residual_size(sensor);

  ShortInput(const ResidualInput& in, Index first, Index last) : begin(lanes - (last - first)) {
    for (Index i = 0; i < lanes; ++i) {
      const Index row = i < begin ? first : last - lanes + i;
      row_camera[i] = in.row_camera[row];
      row_point[i] = in.row_point[row];
      for (int k = 0; k < R; ++k) observed[R * i + k] = in.observed[R * row + k];
    }
  }
  ResidualInput input(ResidualInput in) const {
    in.row_camera = row_camera;
    in.row_point = row_point;
    in.observed = observed;
    return in;
  }

  Index begin;  // the first of its rows
  std::int32_t row_camera[lanes], row_point[lanes];
  double observed[R * lanes];
};

// What it writes, to be copied to where it belongs; that of null is left out.
template <Sensor sensor>
struct ShortOutput {
  static constexpr int R = residual_size(sensor);
  static constexpr int hub_size = camera_unknowns(sensor);

  ResidualOutput output() { return {residual, J_hub, J_leaf, nullptr}; }
  void copy(Index begin, const ResidualOutput& out, Index first) const {
    copy_rows<R>(residual, begin, out.residual, first);
    copy_rows<R * hub_size>(J_hub, begin, out.J_hub, first);
    copy_rows<R * 3>(J_leaf, begin, out.J_leaf, first);
  }

  template <int numbers>
  static void copy_rows(const double* from, Index begin, double* to, Index first) {
    if (to == nullptr) return;
    __builtin_memcpy(to + numbers * first, from + numbers * begin,
                     sizeof(double) * static_cast<std::size_t>(numbers * (lanes - begin)));
  }

  double residual[R * lanes], J_hub[R * hub_size * lanes], J_leaf[R * 3 * lanes];
};

// Calls vectors(in, first, last) for a range.
template <Sensor sensor, class Vectors>
[[gnu::always_inline]] inline double in_vectors(const ResidualInput& in, Index first, Index last,
                                                Vectors&& vectors) {
  if (last - first >= lanes) return vectors(in, first, last);
  const ShortInput<sensor> range(in, first, last);
  return vectors(range.input(in), range.begin, Index{lanes});
}

// Calls vectors(in, out, first, last) for a range.
template <Sensor sensor, class Vectors>
[[gnu::always_inline]] inline double in_vectors(const ResidualInput& in, const ResidualOutput& out,
                                                Index first, Index last, Vectors&& vectors) {
  if (last - first >= lanes) return vectors(in, out, first, last);
  const ShortInput<sensor> range(in, first, last);
  ShortOutput<sensor> written;
  const double cost = vectors(range.input(in), written.output(), range.begin, Index{lanes});
  written.copy(range.begin, out, first);
  return cost;
}

// A range [first, last) is gone through in vectors from rows first, first + lanes, ... on; the last
// one begins early and does some rows again, or before `first`. Such rows must exist, and what is
// written for them is what they have anyway.
[[gnu::always_inline]] inline Index vector_at(Index row, Index last) {
  return row + lanes <= last ? row : last - lanes;
}

// The functions below are compiled once each, so that a row has the same bits in any range.

template <class Observed, class Points>
[[gnu::noinline]] double vectors_cost(const ResidualInput& in, const Points& points, Index first,
                                      Index last) {
  Lanes total = {};
  for (Index row = first; row < last; row += lanes) {
    const Index begin = vector_at(row, last);
    Observed at;
    Lanes r[Observed::R];
    at.template load<false, false>(in, points, begin - first, begin);
    measure(at, r);
    total += from_lane(row - begin, squares<Observed::R>(r));
  }
  return 0.5 * sum(total);
}

template <class Observed, class Points>
[[gnu::noinline]] double vectors_residuals(const ResidualInput& in, const Points& points,
                                           const ResidualOutput& out, Index first, Index last) {
  constexpr int R = Observed::R;
  for (Index row = first; row < last; row += lanes) {
    const Index begin = vector_at(row, last);
    Observed at;
    Lanes r[R];
    at.template load<false, false>(in, points, begin - first, begin);
    measure(at, r);
    store_rows<R>(r, out.residual + R * begin);
  }
  return 0;
}

template <class Observed, PoseUpdate Update, class Points>
[[gnu::noinline]] double vectors_linearize(const ResidualInput& in, const Points& points,
                                           const ResidualOutput& out, Index first, Index last) {
  constexpr int R = Observed::R, hub_size = camera_unknowns(Observed::sensor);
  Lanes total = {};
  for (Index row = first; row < last; row += lanes) {
    const Index begin = vector_at(row, last);
    Observed at;
    Lanes r[R], A[3 * R], L[6], J_leaf[3 * R], J_hub[R * hub_size];
    at.template load<true, Update == PoseUpdate::global>(in, points, begin - first, begin);
    measure(at, r, A, L);
    total += from_lane(row - begin, squares<R>(r));
    for (int i = 0; i < R; ++i) {
      at.template derive<Update>(A + 3 * i, J_leaf + 3 * i, J_hub + hub_size * i);
      for (int k = 6; k < hub_size; ++k) J_hub[hub_size * i + k] = L[3 * i + k - 6];
    }
    store_rows<R>(r, out.residual + R * begin);
    store_rows<3 * R>(J_leaf, out.J_leaf + 3 * R * begin);
    store_rows<R * hub_size>(J_hub, out.J_hub + R * hub_size * begin);
  }
  return 0.5 * sum(total);
}

}  // namespace
}  // namespace raybundle::RAYBUNDLE_ISA
