#pragma once

#include <raybundle/linalg/block_jacobian.h>

#include <vector>

namespace raybundle::linalg {

/// The gradient and the diagonal blocks of H = J^T J [Qu18, Eq. 3.42-3.47]. E is left in the
/// Jacobian, and so is what B has beside its diagonal where leaves are anchored.
struct NormalEquations {
  explicit NormalEquations(const BlockLayout& layout);

  /// g = J^T r, and the diagonal blocks of J^T J.
  void form(const BlockJacobian& J, const double* r, ThreadPool& pool);

  /// J_hub^T J_hub by hub and J_hub^T r, without what hubs do as anchors.
  const double* own_blocks() const { return layout->anchored() ? own_B.data() : B.data(); }
  const double* own_hub_gradient() const {
    return layout->anchored() ? own_gradient.data() : gradient.data();
  }

  const double* blocks(Side side) const { return side == Side::hubs ? B.data() : C.data(); }

  /// Writes diag(H), clamped to [low, high], to d (all unknowns).
  void diagonal(double low, double high, double* d) const;

  /// g^T diag(H)^-1 g over the unknowns that have a diagonal.
  double scaled_gradient_squares() const;

  const BlockLayout* layout;     ///< outlives this
  std::vector<double> B;         ///< hubs x (hub_size x hub_size), symmetric
  std::vector<double> C;         ///< leaves x (leaf_size x leaf_size), symmetric
  std::vector<double> gradient;  ///< hubs, then leaves
  std::vector<double> own_B;     ///< hubs x (hub_size x hub_size); empty without anchors
  std::vector<double> own_gradient;
  std::vector<double> products;  ///< see NormalView
};

}  // namespace raybundle::linalg
