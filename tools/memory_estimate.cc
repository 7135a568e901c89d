#include <raybundle/tools/memory_estimate.h>

#include <raybundle/linalg/coarse_space.h>
#include <raybundle/linalg/dense_cholesky.h>
#include <raybundle/linalg/explicit_system.h>
#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/ordering.h>
#include <raybundle/linalg/schur_complement.h>
#include <raybundle/linalg/supernodal_cholesky.h>
#include <raybundle/models/objective.h>
#include <raybundle/solver/automatic_choice.h>
#include <raybundle/solver/working_memory.h>

#include <algorithm>
#include <utility>

namespace raybundle::tools {
namespace {

constexpr double program = 12e6;  // code, libraries, buffers of the system

/// Collects estimates for one problem.
class Estimator {
 public:
  /// `coarse`: bytes of a coarse space.
  Estimator(const Problem& problem, Lens lens, double coarse)
      : problem_(problem), lens_(lens), coarse_(coarse) {}

  /// `matrix`: bytes of an explicit matrix with its factor.
  void add(Method method, std::optional<Elimination> elimination, Linear linear, double matrix,
           bool upper_bound = false) {
    const PointModel points = method == Method::dogleg ? PointModel::pmba : PointModel::xyz;
    const Options options =
        resolve({.method = method, .elimination = elimination, .lens = lens_, .points = points});
    const double bytes =
        program + problem_memory(problem_) + working_memory(problem_, options) + matrix;
    found.push_back({method, points, elimination, linear, bytes, upper_bound, {}});
    const bool adaptive = options.preconditioner == Preconditioner::adaptive;
    if (adaptive && iterates(linear) && elimination == Elimination::points) {
      found.back().bytes_of_two_levels = bytes + coarse_;
    }
  }

  std::vector<MemoryEstimate> found;

 private:
  const Problem& problem_;
  Lens lens_;
  double coarse_;
};

double sparse_memory(const linalg::SymmetricPattern& pattern) {
  return linalg::SupernodalCholesky::memory(
      pattern, linalg::find_supernodes(pattern, linalg::find_ordering(pattern).permutation),
      linalg::available_threads());
}

/// What `auto` starts with.
LinearCandidate first_choice(const linalg::BlockLayout& layout, linalg::ThreadPool& pool) {
  AutomaticChoice choice(layout, pool, linalg::available_memory());
  const Linear first = choice.decide({}, true);
  const auto& candidates = choice.forecast().candidates();
  return *std::find_if(candidates.begin(), candidates.end(),
                       [&](const LinearCandidate& each) { return each.linear == first; });
}

}  // namespace

MemoryEstimates estimate_memory(const Problem& problem, Lens lens) {
  using E = Elimination;
  linalg::ThreadPool pool(1);
  const Objective objective(problem, {.lens = lens}, pool);
  const linalg::BlockLayout& layout = objective.layout();
  const auto reduced = make_reduced_system(layout, linalg::Side::leaves, pool)->pattern();
  const auto cameras = static_cast<double>(problem.camera_count());
  MemoryEstimates result;
  result.reduced.order = reduced.order();
  result.reduced.fill = static_cast<double>(reduced.column.size()) / (cameras * (cameras + 1) / 2);

  Estimator estimator(problem, lens,
                      linalg::CoarseSpace::memory(layout, linalg::available_threads()));
  const LinearCandidate automatic = first_choice(layout, pool);
  estimator.add(Method::automatic, E::points, automatic.linear, automatic.memory);
  const double dense = linalg::DenseCholesky::memory(reduced.order());
  const double sparse = sparse_memory(reduced);
  estimator.add(Method::lm_cholesky, E::points, Linear::dense_cholesky, dense);
  estimator.add(Method::lm_cholesky, E::points, Linear::sparse_cholesky, sparse);
  estimator.add(Method::lm_cholesky, E::none, Linear::sparse_cholesky,
                sparse_memory(make_reduced_system(layout, std::nullopt, pool)->pattern()));
  estimator.add(Method::lm_cholesky, E::cameras, Linear::dense_cholesky,
                linalg::DenseCholesky::memory(layout.size(linalg::Side::leaves)), true);
  for (const E elimination : {E::points, E::none, E::cameras}) {
    estimator.add(Method::tnm, elimination, Linear::implicit_pcg, 0);
  }
  estimator.add(Method::tnm, E::points, Linear::explicit_pcg,
                linalg::ExplicitSystem::memory(reduced));
  estimator.add(Method::dinm, E::points, Linear::implicit_pcg, 0);
  estimator.add(Method::adinm, std::nullopt, Linear::implicit_pcg, 0);
  // The pattern is that of coordinates: anchors are among the observers of their point.
  estimator.add(Method::dogleg, E::points, Linear::dense_cholesky, dense);
  estimator.add(Method::dogleg, E::points, Linear::sparse_cholesky, sparse);
  result.methods = std::move(estimator.found);
  return result;
}

}  // namespace raybundle::tools
