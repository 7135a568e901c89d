#pragma once

#include <Eigen/Core>

#include <array>
#include <span>

namespace raybundle::init {

/// Essential matrices, of Frobenius norm sqrt(2): a few, up to ten.
class EssentialMatrices {
 public:
  void add(const Eigen::Matrix3d& E) { E_[count_++] = E; }
  std::span<const Eigen::Matrix3d> all() const& { return {E_.data(), count_}; }
  std::span<const Eigen::Matrix3d> all() && = delete;  // it would outlive them

 private:
  std::array<Eigen::Matrix3d, 10> E_;
  std::size_t count_ = 0;
};

using FiveRays = Eigen::Matrix<double, 3, 5>;

/// All real essential matrices E with b_k^T E a_k = 0 for five pairs of rays (columns), of views
/// related by X_b = R X_a + t, E = [t]_x R [Nister04]; by the eigenvectors of an action matrix
/// [Stewenius06]. Any number where the pairs are degenerate.
EssentialMatrices essential_matrices(const FiveRays& a, const FiveRays& b);

}  // namespace raybundle::init
