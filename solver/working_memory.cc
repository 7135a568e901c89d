// Counts what is allocated: models/objective.h, solver/trust_region.h, linalg/schur_complement.h,
// linalg/pcg.h. Numbers are bytes per item; a double or a 64-bit index takes 8.

#include <raybundle/solver/working_memory.h>

#include <raybundle/linalg/schur_complement.h>
#include <raybundle/solver/methods.h>

namespace raybundle {
namespace {

constexpr double word = 8;

struct Sizes {
  double rows, cameras, points;
  double residuals;  // of a row
  double anchors;    // of a point, at most
  double camera_unknowns() const { return 9 * cameras; }
  double point_unknowns() const { return 3 * points; }
  double unknowns() const { return camera_unknowns() + point_unknowns(); }
};

/// What a pass over the points sums for the cameras (linalg/hub_sums.h).
double camera_sums(const Sizes& n, double numbers) {
  const double size = numbers * n.cameras;
  return word * size *
         static_cast<double>(linalg::HubSums::most_parts(static_cast<std::int64_t>(n.rows),
                                                         static_cast<std::int64_t>(size)));
}

/// What every method has: objective, layout, states, Jacobian, normal equations, vectors.
double engine(const Sizes& n) {
  const double objective = (32 + 24) * n.rows + 256 * n.cameras + 8 * n.points;
  const double anchorage = n.anchors > 0 ? word * n.rows + (n.anchors + 1) * word * n.points : 0;
  const double layout = 24 * n.rows + anchorage + 2 * word * (n.cameras + n.points);
  const double states = 2 * word * (n.unknowns() + n.points);
  const double jacobian = n.residuals * 12 * word * n.rows + 27 * n.anchors * word * n.points;
  const double residuals = 2 * n.residuals * word * n.rows;
  const double sums = camera_sums(n, n.anchors > 0 ? 27 : 18);
  const double blocks = word * (9 * n.cameras + 9 * n.points) + sums;
  const double vectors = 4 * word * n.unknowns();
  return objective + layout + states + jacobian + residuals + blocks + vectors;
}

/// What an elimination keeps: M block by block, U = J_e M row by row, and a vector.
double eliminated_side(const Sizes& n, Elimination elimination) {
  if (elimination == Elimination::none) return 0;
  const bool points = elimination == Elimination::points;
  const double size = points ? 3 : 9;
  const double blocks = points ? n.points : n.cameras;
  const double W = n.anchors > 0 ? 27 * n.rows : 0;
  return word * (size * size * blocks + n.residuals * size * n.rows + size * blocks + W);
}

double kept_unknowns(const Sizes& n, Elimination elimination) {
  if (elimination == Elimination::none) return n.unknowns();
  return elimination == Elimination::points ? n.camera_unknowns() : n.point_unknowns();
}

/// Of products and of the diagonal of the reduced matrix; or the rows of a product.
double of_product(const Sizes& n, Elimination elimination) {
  if (elimination != Elimination::points) return n.residuals * word * n.rows;
  return camera_sums(n, 9) + camera_sums(n, linalg::triangle_size(9) + 9);
}

/// Preconditioner with its factors and, of clusters, their modes (their matrix is counted where its
/// sparsity is known, linalg/cholesky.h), what a product needs, and the vectors of the iteration.
double conjugate_gradients(const Sizes& n, Elimination elimination) {
  const double camera_blocks = elimination == Elimination::cameras ? 0 : 81 * n.cameras;
  const double point_blocks = elimination == Elimination::points ? 0 : 9 * n.points;
  const double modes = 2 * 90 * (elimination == Elimination::points ? n.cameras : 0);
  return 2 * word * (camera_blocks + point_blocks) + of_product(n, elimination) + word * modes +
         7 * word * kept_unknowns(n, elimination);
}

double inner_solver(const Sizes& n, const Options& options, Elimination elimination) {
  const bool pcg = has_inner_iterations(traits(options.method));
  return eliminated_side(n, elimination) +
         (pcg ? conjugate_gradients(n, elimination) : word * kept_unknowns(n, elimination));
}

/// solver/diagnosis.h: a system and a factorisation of its own.
double diagnosis(const Sizes& n, const Options& options) {
  if (!options.diagnose) return 0;
  const double lanczos = 100 * n.camera_unknowns();  // its directions, at most
  return eliminated_side(n, Elimination::points) +
         word * (3 * n.unknowns() + n.residuals * n.rows + lanczos);
}

double most_anchors(PointModel points) {
  if (points == PointModel::xyz) return 0;
  return points == PointModel::idp ? 1 : 2;
}

/// What belongs to the methods: a dogleg has both ends of its path and their products.
double dogleg(const Sizes& n, const MethodTraits& method) {
  if (method.inner != InnerSolve::dogleg) return 0;
  return word * (4 * n.unknowns() + n.residuals * n.rows);
}

}  // namespace

double working_memory(const Problem& problem, const Options& options) {
  const Sizes n = {
      static_cast<double>(problem.observation_count()), static_cast<double>(problem.camera_count()),
      static_cast<double>(problem.point_count()),
      options.objective == ObjectiveKind::ray ? 3.0 : 2.0, most_anchors(options.points)};
  const double scaling =
      options.scaling.value_or(DiagonalMatrix::identity) == DiagonalMatrix::identity
          ? 0
          : word * n.unknowns();
  const MethodTraits& method = traits(options.method);
  // solver/block_region.h: a damping of its own, and lengths.
  const double held = method.inner == InnerSolve::pcg && method.bounded && !method.damped
                          ? word * (n.unknowns() + n.points + n.cameras)
                          : 0;
  const double inner = method.adaptive ? inner_solver(n, options, Elimination::points) +
                                             inner_solver(n, options, Elimination::cameras)
                                       : inner_solver(n, options, *options.elimination);
  return engine(n) + scaling + held + inner + dogleg(n, method) + diagnosis(n, options);
}

}  // namespace raybundle
