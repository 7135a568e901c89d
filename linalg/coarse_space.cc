#include <raybundle/linalg/coarse_space.h>

#include <raybundle/linalg/block_factor.h>
#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/schur_complement.h>

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>

namespace raybundle::linalg {
namespace {

constexpr int most_modes = 10;
using Modes =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, most_modes, most_modes>;

// Clusters are neighbours where they share a leaf.
SymmetricPattern cluster_pattern(const HubGraph& graph, const HubClusters& clusters, int modes) {
  SymmetricPattern pattern;
  pattern.offset.push_back(0);
  pattern.row_begin.push_back(0);
  std::vector<std::int32_t> row, last_row(index(clusters.count()), -1);
  for (std::int32_t g = 0; g < clusters.count(); ++g) {
    row.assign(1, g);
    last_row[index(g)] = g;
    for (const std::int32_t hub : clusters.of_cluster(g)) {
      for (const HubGraph::Neighbour& neighbour : graph.of(hub)) {
        const std::int32_t other = clusters.of_hub[index(neighbour.hub)];
        if (other > g && std::exchange(last_row[index(other)], g) != g) row.push_back(other);
      }
    }
    std::sort(row.begin(), row.end());
    pattern.offset.push_back(pattern.offset.back() + modes);
    pattern.column.insert(pattern.column.end(), row.begin(), row.end());
    pattern.row_begin.push_back(static_cast<std::int64_t>(pattern.column.size()));
  }
  return pattern;
}

// Clusters that one leaf touches, at most.
std::int64_t most_touched(const BlockLayout& layout, const HubClusters& clusters,
                          ThreadPool& pool) {
  const auto& begin = layout.leaf_side.begin;
  const Chunks pieces = chunks(layout.leaves, 4096);
  std::array<std::int64_t, max_chunks> most = {};
  pool.run(pieces.pieces, [&](std::int64_t piece) {
    std::vector<std::int64_t> last_leaf(index(clusters.count()), -1);
    for (std::int64_t l = pieces.begin(piece); l < pieces.end(piece); ++l) {
      std::int64_t touched = 0;
      for (std::int64_t c = begin[index(l)]; c < begin[index(l + 1)]; ++c) {
        const std::int32_t g = clusters.of_hub[index(layout.hub_side.block[index(c)])];
        if (std::exchange(last_leaf[index(g)], l) != l) ++touched;
      }
      most[index(piece)] = std::max(most[index(piece)], touched);
    }
  });
  return *std::max_element(most.begin(), most.end());
}

double memory_of(const BlockLayout& layout, const CoarseBasis& basis, const CholeskyPlan& plan,
                 double graph) {
  const auto modes = static_cast<double>(layout.size(Side::hubs) * coarse_modes(layout.hub_size));
  const double kept = plan.memory + SchurComplement::coarse_memory(layout, basis) +
                      8 * (modes + static_cast<double>(layout.unknowns()));
  return std::max(kept, graph);
}

}  // namespace

// Small clusters save inner iterations, large ones work: a factorisation may take that of ten
// products, each of which takes about 200 multiplications a row, where clusters can be so large:
// what is not connected stays apart.
CoarseSpace::Choice CoarseSpace::choose(const BlockLayout& layout, ThreadPool& pool,
                                        double memory_limit) {
  constexpr std::int64_t smallest = 8;
  const double most_work = 10 * 200 * static_cast<double>(layout.rows);
  const HubGraph graph = hub_graph(layout, pool, memory_limit);
  Choice choice;
  for (std::int64_t size = smallest;; size *= 2) {
    choice.clusters = cluster_hubs(graph, size);
    choice.basis.pattern = cluster_pattern(graph, choice.clusters, coarse_modes(layout.hub_size));
    choice.plan = plan_cholesky(choice.basis.pattern, pool.threads());
    const bool larger = choice.clusters.count() > 1 && size < layout.hubs;
    if (choice.plan.work <= most_work || !larger) break;
  }
  choice.basis.cluster = choice.clusters.of_hub;
  choice.basis.most_clusters = most_touched(layout, choice.clusters, pool);
  choice.memory =
      memory_of(layout, choice.basis, choice.plan,
                0.5 * HubGraph::bytes_per_pair * static_cast<double>(graph.neighbours.size()));
  return choice;
}

CoarseSpace::CoarseSpace(const BlockLayout& layout, ThreadPool& pool, double memory_limit)
    : layout_(layout), pool_(pool), modes_(coarse_modes(layout.hub_size)) {
  Choice choice = choose(layout, pool, memory_limit);
  basis_ = std::move(choice.basis);
  clusters_ = std::move(choice.clusters);
  const std::string what = "a coarse space of " + std::to_string(clusters()) + " clusters";
  require_memory(choice.memory, what);
  require_memory(choice.memory, memory_limit, what);
  cholesky_ = Cholesky::make(std::move(choice.plan), pool);
  basis_.P.resize(index(layout.hubs * layout.hub_size * modes_));
  feels_.resize(index(layout.unknowns()));
  c_.resize(index(basis_.pattern.order()));
}

double CoarseSpace::memory(const BlockLayout& layout, ThreadPool& pool) {
  return choose(layout, pool, std::numeric_limits<double>::infinity()).memory;
}

bool CoarseSpace::build(ReducedSystem& system, const Linearization& at,
                        const DiagonalBlocks& diagonal, const double* inverse_scaling) {
  take_modes(at);
  multiply_rows(inverse_scaling, true);
  orthonormalise(diagonal);
  multiply_rows(inverse_scaling, false);
  const double* values = system.coarse_matrix(basis_);
  multiply_rows(inverse_scaling, true);
  // The modes have unit length in the norm of the blocks. A free gauge leaves seven of all clusters
  // together without curvature but the damping's, which may be less than rounding.
  for (const double regularisation : {1e-12, 1e-10, 1e-8, 1e-6}) {
    if (factor(values, regularisation)) return true;
  }
  return false;
}

// What no row feels stays.
void CoarseSpace::take_modes(const Linearization& at) {
  std::copy_n(at.hub_modes, basis_.P.size(), basis_.P.begin());
  at.normal->diagonal(0, std::numeric_limits<double>::max(), feels_.data(), pool_);
  for (std::int64_t i = 0; i < layout_.size(Side::hubs); ++i) {
    if (!(feels_[index(i)] > 0)) std::fill_n(basis_.P.data() + i * modes_, modes_, 0.0);
  }
}

void CoarseSpace::multiply_rows(const double* factors, bool divide) {
  if (factors == nullptr) return;
  for (std::int64_t i = 0; i < layout_.size(Side::hubs); ++i) {
    const double factor = divide ? 1 / factors[i] : factors[i];
    for (int j = 0; j < modes_; ++j) basis_.P[index(i * modes_ + j)] *= factor;
  }
}

// P := P F by cluster, with F F^T = (P^T N P)^-1 and N the diagonal blocks. Modes that depend on
// others, as in a cluster of one hub, become zero.
void CoarseSpace::orthonormalise(const DiagonalBlocks& diagonal) {
  const double* blocks = diagonal.runs.front().values.data();
  const int size = layout_.hub_size * modes_;
  parallel_for(pool_, clusters(), 1, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t g = first; g < last; ++g) {
      Modes gram = Modes::Zero(modes_, modes_), F(modes_, modes_);
      for (const std::int64_t hub : clusters_.of_cluster(g)) {
        const Eigen::Map<const Modes> P(basis_.P.data() + hub * size, layout_.hub_size, modes_);
        const Eigen::Map<const Modes> N(blocks + hub * layout_.hub_size * layout_.hub_size,
                                        layout_.hub_size, layout_.hub_size);
        gram += P.transpose() * Modes(N * P);
      }
      inverse_factor(gram.data(), modes_, F.data());
      for (const std::int64_t hub : clusters_.of_cluster(g)) {
        Eigen::Map<Modes> P(basis_.P.data() + hub * size, layout_.hub_size, modes_);
        P = Modes(P * F);
      }
    }
  });
}

bool CoarseSpace::factor(const double* values, double regularisation) {
  SymmetricBlocks& A = cholesky_->matrix();
  const SymmetricPattern& pattern = basis_.pattern;
  for (std::int64_t g = 0; g < clusters(); ++g) {
    A.set_zero(g);
    for (std::int64_t p = pattern.row_begin[index(g)]; p < pattern.row_begin[index(g + 1)]; ++p) {
      const double* block = values + p * modes_ * modes_;
      for (int i = 0; i < modes_; ++i) {
        std::copy_n(block + i * modes_, modes_, A.row(g) + i * A.stride(g) + A.block_shift(p));
      }
    }
    for (int i = 0; i < modes_; ++i) {
      double& d = A.row(g)[i * A.stride(g) + i];
      d = d > 0 ? d + regularisation : 1;
    }
  }
  return cholesky_->factor();
}

void CoarseSpace::add_correction(const double* r, double* z) {
  const int K = layout_.hub_size, N = modes_;
  parallel_for(pool_, clusters(), 8, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t g = first; g < last; ++g) {
      std::array<double, most_modes> sum = {};
      for (const std::int64_t hub : clusters_.of_cluster(g)) {
        const double* P = basis_.P.data() + hub * K * N;
        for (int i = 0; i < K; ++i, P += N) {
          for (int j = 0; j < N; ++j) sum[index(j)] += P[j] * r[hub * K + i];
        }
      }
      std::copy_n(sum.begin(), N, c_.begin() + g * N);
    }
  });
  cholesky_->solve(c_.data());
  parallel_for(pool_, layout_.hubs, 128, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t hub = first; hub < last; ++hub) {
      const double* P = basis_.P.data() + hub * K * N;
      const double* c = c_.data() + basis_.cluster[index(hub)] * N;
      for (int i = 0; i < K; ++i, P += N) {
        double sum = 0;
        for (int j = 0; j < N; ++j) sum += P[j] * c[j];
        z[hub * K + i] += sum;
      }
    }
  });
}

}  // namespace raybundle::linalg
