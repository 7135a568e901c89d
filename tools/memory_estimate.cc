#include <raybundle/tools/memory_estimate.h>

#include <raybundle/linalg/coarse_space.h>
#include <raybundle/linalg/dense_cholesky.h>
#include <raybundle/linalg/explicit_system.h>
#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/ordering.h>
#include <raybundle/linalg/reduced_pattern.h>
#include <raybundle/linalg/schur_complement.h>
#include <raybundle/linalg/supernodal_cholesky.h>
#include <raybundle/models/objective.h>
#include <raybundle/solver/automatic_choice.h>
#include <raybundle/solver/working_memory.h>

#include <algorithm>
#include <utility>

namespace raybundle::tools {
namespace {

constexpr double program = 14e6;  // code, libraries, stacks, records, the log

/// Collects estimates for one problem.
class Estimator {
 public:
  /// `coarse`: bytes of a coarse space.
  Estimator(const Problem& problem, Lens lens, double coarse)
      : problem_(problem), lens_(lens), coarse_(coarse) {}

  /// `matrix`: bytes of an explicit matrix with its factor.
  void add(Method method, std::optional<Elimination> elimination, Linear linear, double matrix,
           Bound bound = Bound::none) {
    const PointModel points = method == Method::dogleg ? PointModel::pmba : PointModel::xyz;
    const Options options =
        resolve({.method = method, .elimination = elimination, .lens = lens_, .points = points});
    const double bytes =
        program + problem_memory(problem_) + working_memory(problem_, options) + matrix;
    found.push_back({method, points, elimination, linear, bytes, bound, {}});
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

// The matrix of the cameras in its three forms.
struct ReducedMemory {
  double dense, sparse, explicit_matrix;
  Bound of_sparse = Bound::none;
};

// Where not even its sparsity can be held: the numbers alone, twice where a factor stands beside.
ReducedMemory without_sparsity(std::int64_t order, double numbers) {
  return {linalg::DenseCholesky::memory(order), 16 * numbers, 8 * numbers, Bound::at_least};
}

ReducedMemory reduced_memory(const linalg::BlockLayout& layout, ReducedShape& shape,
                             linalg::ThreadPool& pool) {
  using linalg::Side;
  const auto cameras = static_cast<double>(layout.hubs);
  const auto blocks = static_cast<double>(linalg::count_reduced_blocks(layout, Side::leaves, pool));
  shape.order = layout.size(Side::hubs);
  shape.fill = blocks / (cameras * (cameras + 1) / 2);
  try {
    const auto pattern = linalg::reduced_pattern(layout, Side::leaves, pool);
    return {linalg::DenseCholesky::memory(shape.order), sparse_memory(pattern),
            linalg::ExplicitSystem::memory(pattern)};
  } catch (const linalg::MemoryRefusal&) {
    return without_sparsity(shape.order, blocks * layout.hub_size * layout.hub_size);
  }
}

// The matrix of cameras and points, and its factor. To order millions of points takes minutes.
struct FullMemory {
  double bytes;
  Bound bound = Bound::none;
};

FullMemory full_memory(const linalg::BlockLayout& layout, linalg::ThreadPool& pool) {
  constexpr std::int64_t few = 200'000;
  if (layout.rows <= few) {
    return {sparse_memory(make_reduced_system(layout, std::nullopt, pool)->pattern())};
  }
  const auto triangle = [&](linalg::Side side) {
    return layout.block_count(side) * layout.block_size(side) * (layout.block_size(side) + 1) / 2;
  };
  const auto numbers =
      static_cast<double>(triangle(linalg::Side::hubs) + triangle(linalg::Side::leaves) +
                          layout.couplings * layout.hub_size * layout.leaf_size);
  return {16 * numbers, Bound::at_least};
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
  linalg::ThreadPool pool(linalg::available_threads());
  const Objective objective(problem, {.lens = lens}, pool);
  const linalg::BlockLayout& layout = objective.layout();
  MemoryEstimates result;
  const ReducedMemory reduced = reduced_memory(layout, result.reduced, pool);
  Estimator estimator(problem, lens, linalg::CoarseSpace::memory(layout, pool));
  const LinearCandidate automatic = first_choice(layout, pool);
  estimator.add(Method::automatic, E::points, automatic.linear, automatic.memory);
  const auto add_factorised = [&](Method method) {
    estimator.add(method, E::points, Linear::dense_cholesky, reduced.dense);
    estimator.add(method, E::points, Linear::sparse_cholesky, reduced.sparse, reduced.of_sparse);
  };
  add_factorised(Method::lm_cholesky);
  const FullMemory full = full_memory(layout, pool);
  estimator.add(Method::lm_cholesky, E::none, Linear::sparse_cholesky, full.bytes, full.bound);
  estimator.add(Method::lm_cholesky, E::cameras, Linear::dense_cholesky,
                linalg::DenseCholesky::memory(layout.size(linalg::Side::leaves)), Bound::at_most);
  for (const E elimination : {E::points, E::none, E::cameras}) {
    estimator.add(Method::tnm, elimination, Linear::implicit_pcg, 0);
  }
  estimator.add(Method::tnm, E::points, Linear::explicit_pcg, reduced.explicit_matrix,
                reduced.of_sparse);
  estimator.add(Method::dinm, E::points, Linear::implicit_pcg, 0);
  estimator.add(Method::adinm, std::nullopt, Linear::implicit_pcg, 0);
  // The pattern is that of coordinates: anchors are among the observers of their point.
  add_factorised(Method::dogleg);
  result.methods = std::move(estimator.found);
  return result;
}

}  // namespace raybundle::tools
