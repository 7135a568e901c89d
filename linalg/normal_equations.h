#pragma once

#include <raybundle/linalg/block_jacobian.h>

#include <vector>

namespace raybundle::linalg {

/// The gradient, the diagonal and blocks of H = J^T J [Qu18, Eq. 3.42-3.47]. E is left in the
/// Jacobian.
struct NormalEquations {
  explicit NormalEquations(const BlockLayout& layout);

  /// All of it, from J and the residuals r.
  void form(const BlockJacobian& J, const double* r, ThreadPool& pool);

  /// J_hub^T J_hub by hub, J_leaf^T J_leaf by leaf. Of leaves, and of hubs without anchors, these
  /// are the diagonal blocks of H.
  const double* blocks(Side side) const { return side == Side::hubs ? B.data() : C.data(); }
  /// The diagonal blocks of H of a side, anchors included.
  void diagonal_blocks(const BlockJacobian& J, Side side, std::vector<double>& H,
                       ThreadPool& pool) const;

  /// J_hub^T r.
  const double* own_hub_gradient() const {
    return layout->anchored() ? own_gradient_.data() : gradient.data();
  }

  /// Writes diag(H), clamped to [low, high], to d (all unknowns).
  void diagonal(double low, double high, double* d) const;

  /// g^T diag(H)^-1 g over the unknowns that have a diagonal.
  double scaled_gradient_squares() const;

  const BlockLayout* layout;     ///< outlives this
  std::vector<double> B;         ///< hubs x (hub_size x hub_size), symmetric
  std::vector<double> C;         ///< leaves x (leaf_size x leaf_size), symmetric
  std::vector<double> gradient;  ///< J^T r: hubs, then leaves

 private:
  template <class Visit>
  void for_diagonal(Visit&& visit) const;

  std::vector<double> own_gradient_;  // these are empty without anchors; see NormalView
  std::vector<double> hub_diagonal_;
  std::vector<double> products_;
};

}  // namespace raybundle::linalg
