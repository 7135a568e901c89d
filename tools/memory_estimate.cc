// Counts what a solve allocates: solver/trust_region.h, linalg/schur_complement.h and the rest.
// Numbers below are bytes per item unless they say otherwise; a double or 64-bit index takes 8.

#include <raybundle/tools/memory_estimate.h>

#include <raybundle/linalg/ordering.h>
#include <raybundle/linalg/schur_complement.h>
#include <raybundle/models/objective.h>

namespace raybundle::tools {
namespace {

using linalg::Side;

constexpr double program = 12e6;  // code, libraries, buffers of the system
constexpr double word = 8;
// Supernodes store the upper part of their diagonal blocks and some explicit zeros.
constexpr double supernode_overhead = 1.3;
// Values, row indices, and the permuted copies that CHOLMOD analyses and factors (as measured).
constexpr double sparse_entry = 60;

struct Sizes {
  double rows, cameras, points, couplings;
  double camera_unknowns() const { return 9 * cameras; }
  double point_unknowns() const { return 3 * points; }
  double unknowns() const { return camera_unknowns() + point_unknowns(); }
};

Sizes sizes_of(const linalg::BlockLayout& layout) {
  return {static_cast<double>(layout.rows), static_cast<double>(layout.hubs),
          static_cast<double>(layout.leaves), static_cast<double>(layout.couplings)};
}

/// What every method has: problem, objective, layout, states, Jacobian, normal equations, vectors.
double common(const Sizes& n) {
  const double problem = 24 * n.rows + word * n.unknowns();
  const double objective = 24 * n.rows + 192 * n.cameras;
  const double layout = 24 * n.couplings + word * (n.cameras + n.points);
  const double states = 2 * word * n.unknowns();
  const double jacobian = 2 * (9 + 3) * word * n.rows;
  const double residuals = 2 * 2 * word * n.rows;
  const double blocks = word * (81 * n.cameras + 9 * n.points);
  const double vectors = 4 * word * n.unknowns();
  return program + problem + objective + layout + states + jacobian + residuals + blocks + vectors;
}

/// What an elimination keeps: M block by block, U = J_e M row by row, and a vector.
double eliminated_side(const Sizes& n, Elimination elimination) {
  if (elimination == Elimination::none) return 0;
  const bool points = elimination == Elimination::points;
  const double size = points ? 3 : 9;
  const double blocks = points ? n.points : n.cameras;
  return word * (size * size * blocks + 2 * size * n.rows + size * blocks);
}

double kept_unknowns(const Sizes& n, Elimination elimination) {
  if (elimination == Elimination::none) return n.unknowns();
  return elimination == Elimination::points ? n.camera_unknowns() : n.point_unknowns();
}

double pcg(const Sizes& n, Elimination elimination) {
  const bool cameras_kept = elimination != Elimination::cameras;
  const bool points_kept = elimination != Elimination::points;
  const double preconditioner =
      2 * word * ((cameras_kept ? 81 * n.cameras : 0) + (points_kept ? 9 * n.points : 0));
  const double products = 2 * word * n.rows;
  return common(n) + eliminated_side(n, elimination) + preconditioner + products +
         7 * word * kept_unknowns(n, elimination);
}

/// What an explicit matrix is made from: U, or the coupling blocks where nothing is eliminated.
double explicit_blocks(const Sizes& n, Elimination elimination) {
  const double couplings = elimination == Elimination::none ? word * 27 * n.couplings : 0;
  return eliminated_side(n, elimination) + couplings + word * n.unknowns();
}

double dense(const Sizes& n, Elimination elimination) {
  const double order = kept_unknowns(n, elimination);
  return common(n) + explicit_blocks(n, elimination) + word * order * order;
}

/// `entries` of the matrix and of its factor.
double sparse(const Sizes& n, Elimination elimination, double matrix, double factor) {
  return common(n) + explicit_blocks(n, elimination) + sparse_entry * matrix +
         supernode_overhead * word * factor;
}

}  // namespace

MemoryEstimates estimate_memory(const Problem& problem) {
  linalg::ThreadPool pool(1);
  const Objective objective(problem, PoseUpdate::local, Lens::free, pool);
  const linalg::BlockLayout& layout = objective.layout();
  const Sizes n = sizes_of(layout);
  const auto pattern = linalg::SchurComplement(layout, Side::leaves, pool).pattern();
  const double factor = linalg::find_ordering(pattern).nonzeros;
  const auto entries = static_cast<double>(pattern.scalar_nonzeros());

  MemoryEstimates result;
  result.reduced.order = pattern.order();
  const double pairs = n.cameras * (n.cameras + 1) / 2;
  result.reduced.fill = static_cast<double>(pattern.column.size()) / pairs;

  const auto add = [&](Method method, Elimination elimination, Linear linear, double bytes,
                       bool upper_bound = false) {
    result.methods.push_back({method, elimination, linear, bytes, upper_bound});
  };
  using E = Elimination;
  add(Method::lm_cholesky, E::points, Linear::dense_cholesky, dense(n, E::points));
  add(Method::lm_cholesky, E::points, Linear::sparse_cholesky,
      sparse(n, E::points, entries, factor));
  // A good ordering eliminates the points first: their part of the factor is that of the matrix.
  const double full_entries = 81 * n.cameras + 9 * n.points + 27 * n.couplings;
  add(Method::lm_cholesky, E::none, Linear::sparse_cholesky,
      sparse(n, E::none, full_entries, 6 * n.points + 27 * n.couplings + factor));
  add(Method::lm_cholesky, E::cameras, Linear::dense_cholesky, dense(n, E::cameras), true);
  for (const E elimination : {E::points, E::none, E::cameras}) {
    add(Method::tnm, elimination, Linear::implicit_pcg, pcg(n, elimination));
  }
  return result;
}

}  // namespace raybundle::tools
