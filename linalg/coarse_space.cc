#include <raybundle/linalg/coarse_space.h>

#include <raybundle/linalg/block_factor.h>
#include <raybundle/linalg/hub_clusters.h>
#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/schur_complement.h>

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

namespace raybundle::linalg {
namespace {

constexpr int most_modes = 10;
using Modes =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, most_modes, most_modes>;

// Clusters are neighbours where they share a leaf.
SymmetricPattern cluster_pattern(const BlockLayout& layout, const HubClusters& clusters,
                                 std::int64_t& most_clusters) {
  most_clusters = 0;
  std::vector<std::vector<std::int32_t>> rows(index(clusters.count));
  std::vector<std::int32_t> of_leaf;
  for (std::int64_t l = 0; l < layout.leaves; ++l) {
    of_leaf.clear();
    const auto& begin = layout.leaf_side.begin;
    for (std::int64_t c = begin[index(l)]; c < begin[index(l + 1)]; ++c) {
      of_leaf.push_back(clusters.of_hub[index(layout.hub_side.block[index(c)])]);
    }
    std::sort(of_leaf.begin(), of_leaf.end());
    of_leaf.erase(std::unique(of_leaf.begin(), of_leaf.end()), of_leaf.end());
    most_clusters = std::max(most_clusters, static_cast<std::int64_t>(of_leaf.size()));
    for (std::size_t i = 0; i < of_leaf.size(); ++i) {
      std::vector<std::int32_t>& row = rows[index(of_leaf[i])];
      for (std::size_t j = i; j < of_leaf.size(); ++j) {
        const auto at = std::lower_bound(row.begin(), row.end(), of_leaf[j]);
        if (at == row.end() || *at != of_leaf[j]) row.insert(at, of_leaf[j]);
      }
    }
  }
  SymmetricPattern pattern;
  const int modes = coarse_modes(layout.hub_size);
  for (std::int64_t g = 0; g <= clusters.count; ++g) pattern.offset.push_back(g * modes);
  pattern.row_begin.push_back(0);
  for (std::int64_t g = 0; g < clusters.count; ++g) {
    std::vector<std::int32_t>& row = rows[index(g)];
    if (row.empty()) row.push_back(static_cast<std::int32_t>(g));
    pattern.column.insert(pattern.column.end(), row.begin(), row.end());
    pattern.row_begin.push_back(static_cast<std::int64_t>(pattern.column.size()));
  }
  return pattern;
}

// Small clusters save inner iterations, large ones work: a factorisation may take that of ten
// products, each of which takes about 200 multiplications a row, where clusters can be so large:
// what is not connected stays apart. Returns the plan of its matrix, whose sparsity is that of the
// basis.
CholeskyPlan choose_clusters(const BlockLayout& layout, int threads, CoarseBasis& basis) {
  constexpr std::int64_t smallest = 8;
  const double most_work = 10 * 200 * static_cast<double>(layout.rows);
  for (std::int64_t size = smallest;; size *= 2) {
    HubClusters clusters = cluster_hubs(layout, size);
    basis.pattern = cluster_pattern(layout, clusters, basis.most_clusters);
    CholeskyPlan plan = plan_cholesky(basis.pattern, threads);
    if (plan.work > most_work && clusters.count > 1 && size < layout.hubs) continue;
    basis.cluster = std::move(clusters.of_hub);
    return plan;
  }
}

double memory_of(const BlockLayout& layout, const CoarseBasis& basis, const CholeskyPlan& plan) {
  const auto modes = static_cast<double>(layout.size(Side::hubs) * coarse_modes(layout.hub_size));
  return plan.memory + SchurComplement::coarse_memory(layout, basis) +
         8 * (modes + static_cast<double>(layout.unknowns()));
}

}  // namespace

CoarseSpace::CoarseSpace(const BlockLayout& layout, ThreadPool& pool, double memory_limit)
    : layout_(layout), pool_(pool), modes_(coarse_modes(layout.hub_size)) {
  CholeskyPlan plan = choose_clusters(layout, pool.threads(), basis_);
  const double needed = memory_of(layout, basis_, plan);
  const std::string what = "a coarse space of " + std::to_string(clusters()) + " clusters";
  require_memory(needed, what);
  require_memory(needed, memory_limit, what);
  cholesky_ = Cholesky::make(std::move(plan), pool);
  list_hubs();
  basis_.P.resize(index(layout.hubs * layout.hub_size * modes_));
  feels_.resize(index(layout.unknowns()));
  c_.resize(index(basis_.pattern.order()));
}

double CoarseSpace::memory(const BlockLayout& layout, int threads) {
  CoarseBasis basis;
  const CholeskyPlan plan = choose_clusters(layout, threads, basis);
  return memory_of(layout, basis, plan);
}

void CoarseSpace::list_hubs() {
  begin_.assign(index(clusters() + 1), 0);
  for (const std::int32_t g : basis_.cluster) ++begin_[index(g) + 1];
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  hubs_.resize(index(layout_.hubs));
  std::vector<std::int64_t> next(begin_.begin(), begin_.end() - 1);
  for (std::int64_t h = 0; h < layout_.hubs; ++h) {
    hubs_[index(next[index(basis_.cluster[index(h)])]++)] = static_cast<std::int32_t>(h);
  }
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
      for (std::int64_t p = begin_[index(g)]; p < begin_[index(g + 1)]; ++p) {
        const std::int64_t hub = hubs_[index(p)];
        const Eigen::Map<const Modes> P(basis_.P.data() + hub * size, layout_.hub_size, modes_);
        const Eigen::Map<const Modes> N(blocks + hub * layout_.hub_size * layout_.hub_size,
                                        layout_.hub_size, layout_.hub_size);
        gram += P.transpose() * Modes(N * P);
      }
      inverse_factor(gram.data(), modes_, F.data());
      for (std::int64_t p = begin_[index(g)]; p < begin_[index(g + 1)]; ++p) {
        Eigen::Map<Modes> P(basis_.P.data() + hubs_[index(p)] * size, layout_.hub_size, modes_);
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
      for (std::int64_t p = begin_[index(g)]; p < begin_[index(g + 1)]; ++p) {
        const std::int64_t hub = hubs_[index(p)];
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
