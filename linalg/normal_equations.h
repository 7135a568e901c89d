#pragma once

#include <raybundle/linalg/block_jacobian.h>
#include <raybundle/linalg/hub_sums.h>

#include <vector>

namespace raybundle::linalg {

/// The gradient, the diagonal and blocks of H = J^T J [Qu18, Eq. 3.42-3.47]. E is left in the
/// Jacobian, and so are the blocks of hubs, which few methods need.
struct NormalEquations {
  explicit NormalEquations(const BlockLayout& layout);
  static double memory(const LayoutSize& n);

  /// All of it, from J and the residuals r.
  void form(const BlockJacobian& J, const double* r, ThreadPool& pool);

  /// The diagonal blocks of H of a side, anchors included; those of hubs are computed here.
  void diagonal_blocks(const BlockJacobian& J, Side side, std::vector<double>& H,
                       ThreadPool& pool) const;

  /// J_hub^T r.
  const double* own_hub_gradient() const {
    return layout->anchored() ? own_gradient_.data() : gradient.data();
  }

  /// Writes diag(H), clamped to [low, high], to d (all unknowns).
  void diagonal(double low, double high, double* d, ThreadPool& pool) const;

  /// g^T diag(H)^-1 g over the unknowns that have a diagonal.
  double scaled_gradient_squares(ThreadPool& pool) const;

  const BlockLayout* layout;     ///< outlives this
  LargeVector<double> C;         ///< leaves x (leaf_size x leaf_size), symmetric
  LargeVector<double> gradient;  ///< J^T r: hubs, then leaves

 private:
  double diagonal_entry(std::int64_t i) const;

  HubSums sums_;
  std::vector<double> hub_diagonal_;
  std::vector<double> own_gradient_;  // empty without anchors
};

}  // namespace raybundle::linalg
