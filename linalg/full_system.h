#pragma once

#include <raybundle/linalg/reduced_system.h>

namespace raybundle::linalg {

/// (H + D) x = -g with nothing eliminated [Qu18, Eq. 3.61].
class FullSystem final : public ReducedSystem {
 public:
  FullSystem(const BlockLayout& layout, ThreadPool& pool);

  static double memory(const LayoutSize& n) { return 8 * static_cast<double>(n.residuals()); }

  std::int64_t size() const override { return layout_.unknowns(); }
  std::int64_t offset() const override { return 0; }
  void prepare(const Linearization& at, const double* damping) override;
  void gradient(double* v) override;
  void apply(const double* x, double* y) override;
  SymmetricPattern pattern() const override;
  void assemble(SymmetricBlocks& A, double* v) override;
  double expand(const double* x, double* step) override;
  void diagonal_blocks(DiagonalBlocks& out) override;
  void reduced_diagonal(DiagonalBlocks& out, double* v) override;

 private:
  EliminationView view() const;
  std::vector<std::int32_t> hub_neighbours(std::int64_t a) const;
  void write_diagonal(SymmetricBlocks& A, Side side) const;
  void write_couplings(SymmetricBlocks& A) const;
  double* block(SymmetricBlocks& A, std::int64_t a, std::int64_t b) const;
  void add_anchors(SymmetricBlocks& A) const;

  const BlockLayout& layout_;
  ThreadPool& pool_;
  Linearization at_ = {};
  const double* damping_ = nullptr;
  std::vector<double> rows_;  // scratch of apply(), one number per residual
};

}  // namespace raybundle::linalg
