// Bytes and flops of the kernels, derived from the arrays of linalg/block_layout.h,
// block_jacobian.h, normal_equations.h and schur_complement.h, and the loops of linalg/kernels and
// models.
//
// Per row (R residuals, K unknowns of a camera, E of a point): R K numbers of J_hub and R E of
// J_leaf, in single precision, and the 4 bytes that say which camera. Per point: E E numbers of C
// and of M, E of D, g, q and x, and 8 bytes of where its couplings begin. Walking by camera reads
// in addition the list of couplings, 4 bytes a row. What there is per camera stays in the caches
// and is left out. A store counts once, as STREAM counts it.

#include <raybundle/bench/micro/work.h>

#include <raybundle/bench/micro/workload.h>

namespace raybundle::bench {
namespace {

struct Sizes {
  double rows, points, R, K, E;
  double J_hub, J_leaf, observed, of_camera, listed;  // bytes per row
  double block, vector, begin;                        // bytes per point
};

Sizes sizes(const Workload& w) {
  const linalg::BlockLayout& layout = w.layout;
  const double R = layout.row_size, K = layout.hub_size, E = layout.leaf_size;
  return {.rows = static_cast<double>(layout.rows),
          .points = static_cast<double>(layout.leaves),
          .R = R,
          .K = K,
          .E = E,
          .J_hub = 4 * R * K,
          .J_leaf = 4 * R * E,
          .observed = 8 * R,
          .of_camera = 4,
          .listed = 4,
          .block = 8 * E * E,
          .vector = 8 * E,
          .begin = 8};
}

// Reads which camera and point, what was observed, and the point.
double observation_bytes(const Sizes& s) {
  return s.rows * (s.of_camera + 4 + s.observed) + s.points * s.vector;
}

// J_a^T P_ab J_b of one row of a and one of b: J_e of b times what a has of N J_e^T, that times
// J_b, J_a^T times that.
double product_flops(const Sizes& s) {
  return s.R * s.R * (2 * s.E + 2 * s.K) + 2 * s.R * s.K * s.K;
}

// Of one row: M M^T J_e^T.
double left_flops(const Sizes& s) { return 4 * s.R * s.E * s.E; }

}  // namespace

// Flops of models/xyz_rows_impl.h with a BAL lens: 18 to camera coordinates, 42 for the lens and
// its derivatives, 9 for the residual and the aspect, 4 for the cost, 2 x 15 for J_leaf and 2 x 9
// for the rotation (the derivative by the translation is J_leaf). Of the normal equations: J^T r,
// the diagonal of cameras, the blocks of points. Rows, C and g are written.
Work linearize_work(const Workload& w) {
  const Sizes s = sizes(w);
  const double bytes = observation_bytes(s) + s.rows * (s.J_hub + s.J_leaf) +
                       s.points * (s.begin + s.block + s.vector);
  return {bytes, s.rows * (121 + 2 * s.R * (2 * s.K + s.E * (s.E + 1)))};
}

// 18 to camera coordinates, 13 for the lens, 3 for the residual, 4 for the cost.
Work cost_work(const Workload& w) {
  const Sizes s = sizes(w);
  return {observation_bytes(s), s.rows * 38};
}

// M from C and D, and q from M and g: a Cholesky factor and its inverse, E^3 / 3 each.
Work prepare_work(const Workload& w) {
  const Sizes s = sizes(w);
  return {s.points * (2 * s.block + 3 * s.vector),
          s.points * (2 * s.E * s.E * s.E / 3 + 4 * s.E * s.E)};
}

// By camera: a row, and q of its point.
Work gradient_work(const Workload& w) {
  const Sizes s = sizes(w);
  return {s.rows * (s.J_hub + s.J_leaf + s.listed + 4) + s.points * s.vector,
          s.rows * 2 * s.R * (s.E + s.K)};
}

// By point: rows once, and M. Flops: J_k x, J_e^T of that, M M^T of that, J_e of that, J_k^T of the
// difference.
Work apply_work(const Workload& w) {
  const Sizes s = sizes(w);
  return {s.rows * (s.J_hub + s.J_leaf + s.of_camera) + s.points * (s.begin + s.block),
          s.rows * 4 * s.R * (s.K + s.E) + s.points * 4 * s.E * s.E};
}

// By point: rows, M and q; the right side comes with it.
Work diagonal_work(const Workload& w) {
  const Sizes s = sizes(w);
  return {s.rows * (s.J_hub + s.J_leaf + s.of_camera) + s.points * (s.begin + s.block + s.vector),
          s.rows * (product_flops(s) + left_flops(s) + 2 * s.R * (s.E + s.K))};
}

// Reads at least the rows, the list, M and q once and writes S; the flops are those of all couples
// of rows, of the upper half of S.
Work assemble_work(const Workload& w) {
  const Sizes s = sizes(w);
  const double S = 8 * static_cast<double>(w.reduced_nonzeros());
  return {gradient_work(w).bytes + s.rows * 8 + s.points * s.block + S,
          static_cast<double>(w.couples) * product_flops(s) + s.rows * left_flops(s) +
              gradient_work(w).flops};
}

// By point: rows, M and q; writes x. Flops: J_k x, J_e^T of that, M M^T of that, J_e of the step,
// squares.
Work expand_work(const Workload& w) {
  const Sizes s = sizes(w);
  return {
      s.rows * (s.J_hub + s.J_leaf + s.of_camera) + s.points * (s.begin + s.block + 2 * s.vector),
      s.rows * s.R * (2 * s.K + 4 * s.E + 3) + s.points * 4 * s.E * s.E};
}

}  // namespace raybundle::bench
