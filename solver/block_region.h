#pragma once

#include <raybundle/solver/step.h>

#include <vector>

namespace raybundle {

/// The region of eliminated blocks that no damping holds. A trust region bounds the unknowns that
/// are solved for; as it shrinks, the step of an eliminated block tends to -C_i^-1 g_i, which for a
/// block close to singular may be anywhere. With the damping lambda_i = |D^-1 g_i| / radius it is
/// |D (C_i + lambda_i D^2)^-1 g_i| <= radius, and lambda_i vanishes with the gradient.
class BlockRegion {
 public:
  BlockRegion(const linalg::BlockLayout& layout, std::optional<linalg::Side> eliminated)
      : layout_(layout), side_(eliminated) {}

  /// Bytes: a damping of its own, and lengths twice, of which the median is taken.
  static double memory(const linalg::LayoutSize& n, linalg::Side eliminated) {
    return 8 * static_cast<double>(n.unknowns() + 2 * n.block_count(eliminated));
  }

  /// The damping of the request, raised where its block radius asks for it; valid until the next
  /// call.
  const double* hold(const StepRequest& request);

  /// Reports how far the blocks went. A free step sets the scale of their radius: ten times its
  /// median moving block, since a few may have gone anywhere.
  void measure(const StepRequest& request, const double* step, StepReport& report);

 private:
  template <class Visit>
  void for_blocks(Visit&& visit) const;

  const linalg::BlockLayout& layout_;
  std::optional<linalg::Side> side_;
  std::vector<double> damping_;
  std::vector<double> lengths_;
};

}  // namespace raybundle
