#pragma once

#include <raybundle/linalg/cholesky.h>
#include <raybundle/linalg/reduced_system.h>

#include <memory>
#include <vector>

namespace raybundle::linalg {

/// The coarse part of a two-level preconditioner, P (P^T A P)^-1 P^T, for the Schur complement A of
/// the leaves. Clusters of hubs move as Linearization::hub_modes say; what no row feels (what is
/// held, and hubs without leaves) does not move with them.
class CoarseSpace {
 public:
  /// `layout` and `pool` outlive it. Throws std::bad_alloc.
  CoarseSpace(const BlockLayout& layout, ThreadPool& pool);

  /// From a prepared system, its linearisation, and the diagonal blocks of A. False where P^T A P
  /// has no factor: then there is nothing to apply.
  bool build(ReducedSystem& system, const Linearization& at, const DiagonalBlocks& diagonal);
  /// The space of the unknowns D x instead; call after build().
  void scale(const double* inverse_scaling);

  /// z += P (P^T A P)^-1 P^T r.
  void add_correction(const double* r, double* z);

  std::int64_t clusters() const { return basis_.pattern.blocks(); }
  std::int64_t order() const { return basis_.pattern.order(); }

 private:
  void take_modes(const Linearization& at);
  void orthonormalise(const DiagonalBlocks& diagonal);
  bool factor(const double* values, double regularisation);

  const BlockLayout& layout_;
  ThreadPool& pool_;
  int modes_;
  CoarseBasis basis_;
  std::vector<std::int64_t> begin_;  // of a cluster in
  std::vector<std::int32_t> hubs_;   // the hubs, cluster by cluster
  std::unique_ptr<Cholesky> cholesky_;
  std::vector<double> feels_;  // diag(H) of the hubs
  std::vector<double> c_;
};

}  // namespace raybundle::linalg
