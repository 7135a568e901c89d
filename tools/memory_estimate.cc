#include <raybundle/tools/memory_estimate.h>

#include <raybundle/linalg/dense_cholesky.h>
#include <raybundle/linalg/explicit_system.h>
#include <raybundle/linalg/ordering.h>
#include <raybundle/linalg/schur_complement.h>
#include <raybundle/linalg/supernodal_cholesky.h>
#include <raybundle/models/objective.h>
#include <raybundle/solver/working_memory.h>

namespace raybundle::tools {
namespace {

constexpr double program = 12e6;  // code, libraries, buffers of the system

/// What is there before a matrix is: the program, the problem, and the engine's own.
double before_matrix(const Problem& problem, Method method,
                     std::optional<Elimination> elimination) {
  const double numbers = static_cast<double>(problem.cameras.size() + problem.points.size());
  const double observations = static_cast<double>(problem.observation_count());
  const Options options = resolve({.method = method, .elimination = elimination});
  return program + 8 * numbers + 24 * observations + working_memory(problem, options);
}

}  // namespace

MemoryEstimates estimate_memory(const Problem& problem) {
  linalg::ThreadPool pool(1);
  const Objective objective(problem, {}, pool);
  MemoryEstimates result;
  const auto add = [&](Method method, std::optional<Elimination> elimination, Linear linear,
                       double matrix, bool upper_bound = false) {
    const double bytes = before_matrix(problem, method, elimination) + matrix;
    result.methods.push_back({method, elimination, linear, bytes, upper_bound});
  };
  const auto sparse = [&](const linalg::SymmetricPattern& pattern) {
    return linalg::SupernodalCholesky::memory(
        pattern, linalg::find_supernodes(pattern, linalg::find_ordering(pattern).permutation),
        linalg::available_threads());
  };
  using E = Elimination;

  const linalg::BlockLayout& layout = objective.layout();
  const auto reduced = make_reduced_system(layout, linalg::Side::leaves, pool)->pattern();
  const auto cameras = static_cast<double>(problem.camera_count());
  result.reduced.order = reduced.order();
  result.reduced.fill = static_cast<double>(reduced.column.size()) / (cameras * (cameras + 1) / 2);
  add(Method::lm_cholesky, E::points, Linear::dense_cholesky,
      linalg::DenseCholesky::memory(reduced.order()));
  add(Method::lm_cholesky, E::points, Linear::sparse_cholesky, sparse(reduced));
  add(Method::lm_cholesky, E::none, Linear::sparse_cholesky,
      sparse(make_reduced_system(layout, std::nullopt, pool)->pattern()));
  add(Method::lm_cholesky, E::cameras, Linear::dense_cholesky,
      linalg::DenseCholesky::memory(layout.size(linalg::Side::leaves)), true);
  for (const E elimination : {E::points, E::none, E::cameras}) {
    add(Method::tnm, elimination, Linear::implicit_pcg, 0);
  }
  add(Method::tnm, E::points, Linear::explicit_pcg, linalg::ExplicitSystem::memory(reduced));
  add(Method::dinm, E::points, Linear::implicit_pcg, 0);
  add(Method::adinm, std::nullopt, Linear::implicit_pcg, 0);
  return result;
}

}  // namespace raybundle::tools
