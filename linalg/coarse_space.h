#pragma once

#include <raybundle/linalg/cholesky.h>
#include <raybundle/linalg/hub_clusters.h>
#include <raybundle/linalg/reduced_system.h>

#include <limits>
#include <memory>
#include <vector>

namespace raybundle::linalg {

/// The coarse part of a two-level preconditioner, P (P^T A P)^-1 P^T, for the Schur complement A of
/// the leaves; the fine part are the diagonal blocks, and the two are added. Clusters of hubs move
/// as Linearization::hub_modes say; what no row feels (what is held, and hubs without leaves) does
/// not move with them.
class CoarseSpace {
 public:
  /// `layout` and `pool` outlive it. Throws MemoryRefusal where it would take more than is
  /// available or than `memory_limit` bytes.
  CoarseSpace(const BlockLayout& layout, ThreadPool& pool,
              double memory_limit = std::numeric_limits<double>::infinity());

  /// From a prepared system, its linearisation, and the diagonal blocks of A; of the unknowns D x
  /// with D^-1 A D^-1 where `inverse_scaling` has D^-1, else it is null. False where P^T A P has no
  /// factor: then there is nothing to apply.
  bool build(ReducedSystem& system, const Linearization& at, const DiagonalBlocks& diagonal,
             const double* inverse_scaling);

  /// z += P (P^T A P)^-1 P^T r.
  void add_correction(const double* r, double* z);

  /// Bytes of it and of what the Schur complement takes for it. Chooses the clusters.
  static double memory(const BlockLayout& layout, ThreadPool& pool);

  std::int64_t clusters() const { return clusters_.count(); }
  const CoarseBasis& basis() const { return basis_; }  ///< as the last build() left it

 private:
  // The clusters, the sparsity of their matrix and what all of it takes.
  struct Choice {
    HubClusters clusters;
    CoarseBasis basis;
    CholeskyPlan plan;
    double memory = 0;
  };
  static Choice choose(const BlockLayout& layout, ThreadPool& pool, double memory_limit);

  void take_modes(const Linearization& at);
  void orthonormalise(const DiagonalBlocks& diagonal);
  void multiply_rows(const double* factors, bool divide);
  bool factor(const double* values, double regularisation);

  const BlockLayout& layout_;
  ThreadPool& pool_;
  int modes_;
  CoarseBasis basis_;
  HubClusters clusters_;
  std::unique_ptr<Cholesky> cholesky_;
  LargeVector<double> feels_;  // diag(H); of the hubs at first
  std::vector<double> c_;
};

}  // namespace raybundle::linalg
