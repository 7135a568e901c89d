// Bytes and flops of the kernels, derived from the arrays of linalg/block_layout.h,
// block_jacobian.h, normal_equations.h and schur_complement.h, and the loops of linalg/kernels and
// models.
//
// Per row (R residuals, K unknowns of a camera, E of a point): R K numbers of J_hub, R E of J_leaf
// and of U, R of r, and the 4 bytes that say which camera. Per point: E E numbers of C and of M, E
// of D, g, y and x, and 8 bytes of where its couplings begin. Walking by camera reads in addition
// the list of couplings, 8 bytes a row. What there is per camera stays in the caches and is left
// out. A store counts once, as STREAM counts it.

#include <raybundle/bench/micro/work.h>

#include <raybundle/bench/micro/workload.h>

namespace raybundle::bench {
namespace {

struct Sizes {
  double rows, points, R, K, E;
  double J_hub, J_leaf, U, r, of_camera, listed;  // bytes per row
  double block, vector, begin;                    // bytes per point
};

Sizes sizes(const Workload& w) {
  const linalg::BlockLayout& layout = w.layout;
  const double R = layout.row_size, K = layout.hub_size, E = layout.leaf_size;
  return {.rows = static_cast<double>(layout.rows),
          .points = static_cast<double>(layout.leaves),
          .R = R,
          .K = K,
          .E = E,
          .J_hub = 8 * R * K,
          .J_leaf = 8 * R * E,
          .U = 8 * R * E,
          .r = 8 * R,
          .of_camera = 4,
          .listed = 4,
          .block = 8 * E * E,
          .vector = 8 * E,
          .begin = 8};
}

// Reads which camera and point, what was observed, and the point.
double observation_bytes(const Sizes& s) {
  return s.rows * (s.of_camera + 4 + s.r) + s.points * s.vector;
}

// J_a^T P_ab J_b of one row of a and one of b: U_a U_b^T, that times J_b, J_a^T times that.
double product_flops(const Sizes& s) {
  return s.R * s.R * (2 * s.E + 2 * s.K) + 2 * s.R * s.K * s.K;
}

}  // namespace

// Flops of models/xyz_rows_impl.h with a BAL lens: 18 to camera coordinates, 43 for the lens and
// its derivatives, 9 for the residual and the aspect, 4 for the cost, 2 x 15 for J_leaf and 2 x 9
// for the rotation (the derivative by the translation is J_leaf).
Work linearize_work(const Workload& w) {
  const Sizes s = sizes(w);
  return {observation_bytes(s) + s.rows * (s.J_hub + s.J_leaf + s.r), s.rows * 122};
}

// 18 to camera coordinates, 13 for the lens, 3 for the residual, 4 for the cost.
Work cost_work(const Workload& w) {
  const Sizes s = sizes(w);
  return {observation_bytes(s), s.rows * 38};
}

// Reads J_hub, J_leaf and r by point, writes C and g; of cameras only the diagonal is formed.
Work normal_work(const Workload& w) {
  const Sizes s = sizes(w);
  const double bytes =
      s.rows * (s.J_hub + s.J_leaf + s.r + s.of_camera) + s.points * (s.begin + s.block + s.vector);
  return {bytes, s.rows * 2 * s.R * (2 * s.K + s.E * (s.E + 1))};
}

// First M from C and D; then U from J_leaf and M, and y from g and M. Flops: a Cholesky factor and
// its inverse, E^3 / 3 each, and M transposed times the rows and the gradient.
Work prepare_work(const Workload& w) {
  const Sizes s = sizes(w);
  const double factor = s.points * (2 * s.block + s.vector);
  const double transform =
      s.rows * (s.J_leaf + s.U) + s.points * (s.begin + s.block + 2 * s.vector);
  return {factor + transform,
          s.rows * 2 * s.R * s.E * s.E + s.points * (2 * s.E * s.E * s.E / 3 + 2 * s.E * s.E)};
}

// By camera: J_hub, U, and y of the row's point.
Work gradient_work(const Workload& w) {
  const Sizes s = sizes(w);
  return {s.rows * (s.J_hub + s.U + s.listed + 4) + s.points * s.vector,
          s.rows * 2 * s.R * (s.E + s.K)};
}

// By point: J_hub and U, once. Flops: J x, U^T of that, U times that, J^T of the difference.
Work apply_work(const Workload& w) {
  const Sizes s = sizes(w);
  return {s.rows * (s.J_hub + s.U + s.of_camera) + s.points * s.begin,
          s.rows * 4 * s.R * (s.K + s.E)};
}

// By point: J_hub, U and y; the right side comes with it.
Work diagonal_work(const Workload& w) {
  const Sizes s = sizes(w);
  return {s.rows * (s.J_hub + s.U + s.of_camera) + s.points * (s.begin + s.vector),
          s.rows * (product_flops(s) + 2 * s.R * (s.E + s.K))};
}

// Reads at least J_hub, U, the list and y once and writes S; the flops are those of all couples of
// rows, of the upper half of S.
Work assemble_work(const Workload& w) {
  const Sizes s = sizes(w);
  const double S = 8 * static_cast<double>(w.reduced_nonzeros());
  return {gradient_work(w).bytes + s.rows * 8 + S,
          static_cast<double>(w.couples) * product_flops(s) + gradient_work(w).flops};
}

// By point: J_hub, U, M and y; writes x. Flops: J x, U^T of that, M times that, U times t, squares.
Work expand_work(const Workload& w) {
  const Sizes s = sizes(w);
  return {s.rows * (s.J_hub + s.U + s.of_camera) + s.points * (s.begin + s.block + 2 * s.vector),
          s.rows * s.R * (2 * s.K + 4 * s.E + 3) + s.points * 2 * s.E * s.E};
}

}  // namespace raybundle::bench
