// How residual kernels walk over rows: as many at a time as a vector has lanes.

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
                                                const std::int32_t* row_camera,
                                                CameraLanes& out) {
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

// A range [first, last) is gone through in vectors from rows first, first + lanes, ... on; the last
// one begins early and does some rows again, or before `first`. Such rows must exist, and what is
// written for them is what they have anyway.
[[gnu::always_inline]] inline Index vector_at(Index row, Index last) {
  return row + lanes <= last ? row : last - lanes;
}

// A range that is shorter than a vector, as the last rows of a vector whose other lanes repeat the
// first one: by the same code, so that a row has the same bits wherever it stands.
template <Sensor sensor>
struct ShortRange {
  static constexpr int R = residual_size(sensor);
  static constexpr int hub_size = camera_unknowns(sensor);

  ShortRange(const ResidualInput& in, Index first, Index last) : rows(last - first) {
    for (Index i = 0; i < lanes; ++i) {
      const Index row = i < begin() ? first : last - lanes + i;
      row_camera[i] = in.row_camera[row];
      row_point[i] = in.row_point[row];
      for (int k = 0; k < R; ++k) observed[R * i + k] = in.observed[R * row + k];
    }
  }
  Index begin() const { return lanes - rows; }
  ResidualInput input(ResidualInput in) const {
    in.row_camera = row_camera;
    in.row_point = row_point;
    in.observed = observed;
    return in;
  }
  ResidualOutput output() { return {residual, J_hub, J_leaf, nullptr}; }

  void copy_residual(double* to) const {
    __builtin_memcpy(to, residual + R * begin(), sizeof(double) * index(R * rows));
  }
  void copy(const ResidualOutput& out, Index first) const {
    copy_residual(out.residual + R * first);
    __builtin_memcpy(out.J_hub + R * hub_size * first, J_hub + R * hub_size * begin(),
                     sizeof(double) * index(R * hub_size * rows));
    __builtin_memcpy(out.J_leaf + R * 3 * first, J_leaf + R * 3 * begin(),
                     sizeof(double) * index(R * 3 * rows));
  }

  static std::size_t index(Index i) { return static_cast<std::size_t>(i); }

  Index rows;
  std::int32_t row_camera[lanes], row_point[lanes];
  double observed[R * lanes];
  double residual[R * lanes], J_hub[R * hub_size * lanes], J_leaf[R * 3 * lanes];
};

}  // namespace
}  // namespace raybundle::RAYBUNDLE_ISA
