// P^T A P of a Schur complement, in one pass over the leaves.

#include <raybundle/linalg/schur_complement.h>

#include <stdexcept>

namespace raybundle::linalg {

const double* SchurComplement::coarse_matrix(const CoarseBasis& basis) {
  if (eliminated_ == Side::hubs) return ReducedSystem::coarse_matrix(basis);
  const std::int64_t modes = coarse_modes(layout_.hub_size);
  const auto clusters = index(basis.pattern.blocks());
  coarse_scratch_.place.assign(max_chunks * clusters, -1);
  coarse_scratch_.found.resize(index(max_chunks * basis.most_clusters));
  coarse_scratch_.numbers.resize(index(max_chunks * basis.most_clusters *
                                       coarse_numbers(layout_.hub_size, layout_.leaf_size)));
  const auto blocks = static_cast<std::int64_t>(basis.pattern.column.size());
  double* sums = coarse_sums_.form_all(
      layout_, blocks * modes * modes, pool_,
      [&](std::int64_t first, std::int64_t last, std::int64_t piece, double* part) {
        kernels().coarse_products(view(), coarse_view(basis, piece), first, last, part);
      });
  add_coarse_damping(basis, sums);
  return sums;
}

double SchurComplement::coarse_memory(const BlockLayout& layout, const CoarseBasis& basis) {
  const std::int64_t modes = coarse_modes(layout.hub_size);
  const auto blocks = static_cast<std::int64_t>(basis.pattern.column.size());
  const std::int64_t numbers = coarse_numbers(layout.hub_size, layout.leaf_size);
  const auto scratch =
      static_cast<double>(4 * basis.pattern.blocks() + (4 + 8 * numbers) * basis.most_clusters);
  return HubSums::memory_of_all(layout, blocks * modes * modes) + max_chunks * scratch;
}

CoarseView SchurComplement::coarse_view(const CoarseBasis& basis, std::int64_t piece) {
  const std::int64_t numbers = coarse_numbers(layout_.hub_size, layout_.leaf_size);
  return {basis.cluster.data(),
          basis.P.data(),
          basis.pattern.row_begin.data(),
          basis.pattern.column.data(),
          coarse_scratch_.place.data() + piece * basis.pattern.blocks(),
          coarse_scratch_.found.data() + piece * basis.most_clusters,
          coarse_scratch_.numbers.data() + piece * basis.most_clusters * numbers};
}

// P^T D P, which is block diagonal.
void SchurComplement::add_coarse_damping(const CoarseBasis& basis, double* values) const {
  const std::int64_t modes = coarse_modes(layout_.hub_size);
  const double* P = basis.P.data();
  const double* D = damping(Side::hubs);
  for (std::int64_t h = 0; h < layout_.hubs; ++h) {
    const std::int32_t cluster = basis.cluster[index(h)];
    double* block = values + basis.pattern.row_begin[index(cluster)] * modes * modes;
    for (int k = 0; k < layout_.hub_size; ++k, P += modes, ++D) {
      for (std::int64_t i = 0; i < modes; ++i) {
        for (std::int64_t j = 0; j < modes; ++j) block[i * modes + j] += P[i] * *D * P[j];
      }
    }
  }
}

}  // namespace raybundle::linalg
