#include <raybundle/linalg/coarse_space.h>

#include <raybundle/linalg/block_factor.h>
#include <raybundle/linalg/hub_clusters.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstdio>
#include <limits>
#include <utility>

namespace raybundle::linalg {
namespace {

constexpr std::size_t most_modes = 12;

// Clusters are neighbours where they share a leaf.
SymmetricPattern cluster_pattern(const BlockLayout& layout, const HubClusters& clusters,
                                 std::int64_t& most_clusters) {
  std::vector<std::vector<std::int32_t>> rows(index(clusters.count));
  std::vector<std::int32_t> of_leaf;
  for (std::int64_t l = 0; l < layout.leaves; ++l) {
    of_leaf.clear();
    const std::vector<std::int64_t>& begin = layout.leaf_side.begin;
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

}  // namespace

CoarseSpace::CoarseSpace(const BlockLayout& layout, ThreadPool& pool)
    : layout_(layout), pool_(pool), modes_(coarse_modes(layout.hub_size)) {
  const char* e = std::getenv("CLUSTER");
  HubClusters clusters = cluster_hubs(layout, e ? std::atoi(e) : 12);
  if (std::getenv("ORDER")) { int n = e ? std::atoi(e) : 12; clusters.count = (layout.hubs + n - 1) / n; for (int h = 0; h < layout.hubs; ++h) clusters.of_hub[h] = h / n; }
  basis_.pattern = cluster_pattern(layout, clusters, basis_.most_clusters);
  basis_.cluster = clusters.of_hub;
  basis_.P.resize(index(layout.hubs * layout.hub_size * modes_));
  begin_.assign(index(clusters.count + 1), 0);
  for (const std::int32_t g : basis_.cluster) ++begin_[index(g) + 1];
  for (std::size_t g = 1; g < begin_.size(); ++g) begin_[g] += begin_[g - 1];
  hubs_.resize(index(layout.hubs));
  std::vector<std::int64_t> next(begin_.begin(), begin_.end() - 1);
  for (std::int64_t h = 0; h < layout.hubs; ++h) {
    hubs_[index(next[index(basis_.cluster[index(h)])]++)] = static_cast<std::int32_t>(h);
  }
  cholesky_ = Cholesky::make(plan_cholesky(basis_.pattern), pool);
  c_.resize(index(basis_.pattern.order()));
}

bool CoarseSpace::build(ReducedSystem& system, const Linearization& at,
                        const DiagonalBlocks& diagonal) {
  take_modes(at);
  orthonormalise(diagonal);
  const double* values = system.coarse_matrix(basis_);
  // The modes have unit length in the norm of the blocks. A free gauge leaves seven of all clusters
  // together without curvature but the damping's, which may be less than rounding.
  for (double regularisation = 1e-12; regularisation < 1e-5; regularisation *= 100) {
    if (factor(values, regularisation)) { if (std::getenv("DBG")) { int z=0; for (int g=0; g<clusters(); ++g) for (int i=0;i<modes_;++i) z += values[basis_.pattern.row_begin[g]*modes_*modes_+i*(modes_+1)]==0; fprintf(stderr,"reg %g clusters %ld blocks %zu zero %d most %ld %s\n", regularisation, clusters(), basis_.pattern.column.size(), z, basis_.most_clusters, cholesky_->description().c_str()); if (std::getenv("DBG")[0]==50) for (int g=0; g<clusters(); ++g) fprintf(stderr, "%ld ", begin_[g+1]-begin_[g]);} return true; }
  }
  return false;
}

// What no row feels stays.
void CoarseSpace::take_modes(const Linearization& at) {
  std::copy_n(at.hub_modes, basis_.P.size(), basis_.P.begin());
  feels_.resize(index(layout_.unknowns()));
  at.normal->diagonal(0, std::numeric_limits<double>::max(), feels_.data());
  for (std::int64_t i = 0; i < layout_.size(Side::hubs); ++i) {
    if (!(feels_[index(i)] > 0)) std::fill_n(basis_.P.data() + i * modes_, modes_, 0.0);
  }
}

// P := P F by cluster, with F F^T = (P^T N P)^-1 and N the diagonal blocks. Modes that depend on
// others, as in a cluster of one hub, become zero.
void CoarseSpace::orthonormalise(const DiagonalBlocks& diagonal) {
  const int K = layout_.hub_size, N = modes_;
  const double* blocks = diagonal.runs.front().values.data();
  parallel_for(pool_, clusters(), 1, [&](std::int64_t first, std::int64_t last) {
    std::array<double, most_modes * most_modes> gram, F;
    std::array<double, most_modes> row;
    for (std::int64_t g = first; g < last; ++g) {
      gram.fill(0);
      for (std::int64_t p = begin_[index(g)]; p < begin_[index(g + 1)]; ++p) {
        const std::int64_t hub = hubs_[index(p)];
        const double* block = blocks + hub * K * K;
        const double* P = basis_.P.data() + hub * K * N;
        for (int i = 0; i < K; ++i) {
          row.fill(0);
          for (int k = 0; k < K; ++k) {
            for (int j = 0; j < N; ++j) row[index(j)] += block[i * K + k] * P[k * N + j];
          }
          for (int m = 0; m < N; ++m) {
            for (int j = 0; j < N; ++j) gram[index(m * N + j)] += P[i * N + m] * row[index(j)];
          }
        }
      }
      inverse_factor(gram.data(), N, F.data());
      for (std::int64_t p = begin_[index(g)]; p < begin_[index(g + 1)]; ++p) {
        double* P = basis_.P.data() + hubs_[index(p)] * K * N;
        for (int i = 0; i < K; ++i, P += N) {
          row.fill(0);
          for (int m = 0; m < N; ++m) {
            for (int j = 0; j < N; ++j) row[index(j)] += P[m] * F[index(m * N + j)];
          }
          std::copy_n(row.begin(), N, P);
        }
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

void CoarseSpace::scale(const double* inverse_scaling) {
  for (std::int64_t i = 0; i < layout_.size(Side::hubs); ++i) {
    for (int j = 0; j < modes_; ++j) basis_.P[index(i * modes_ + j)] /= inverse_scaling[i];
  }
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
