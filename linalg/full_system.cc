#include <raybundle/linalg/full_system.h>

#include <Eigen/Core>

#include <algorithm>

namespace raybundle::linalg {

FullSystem::FullSystem(const BlockLayout& layout, ThreadPool& pool)
    : layout_(layout), pool_(pool) {}

void FullSystem::prepare(const Linearization& at, const double* damping) {
  at_ = at;
  damping_ = damping;
}

void FullSystem::gradient(double* v) { std::copy_n(at_.normal->gradient.data(), size(), v); }

void FullSystem::apply(const double* x, double* y) {
  rows_.resize(index(layout_.residuals()));
  multiply(*at_.J, x, rows_.data(), pool_);
  transpose_multiply(*at_.J, rows_.data(), y, pool_);
  for (std::int64_t i = 0; i < size(); ++i) y[i] += damping_[i] * x[i];
}

double FullSystem::expand(const double* x, double* step) {
  std::copy_n(x, size(), step);
  return multiply_squares(*at_.J, x, pool_);
}

// The hubs after a that share a leaf with a, one of both being its anchor.
std::vector<std::int32_t> FullSystem::hub_neighbours(std::int64_t a) const {
  std::vector<std::int32_t> found;
  if (!layout_.anchored()) return found;
  const Incidence& hubs = layout_.hub_side;
  const Incidence& leaves = layout_.leaf_side;
  const std::vector<std::int32_t>& anchor = layout_.anchorage.anchor;
  for (std::int64_t p = hubs.begin[index(a)]; p < hubs.begin[index(a + 1)]; ++p) {
    const std::int64_t c = hubs.list[index(p)];
    const std::int64_t end = leaves.begin[index(leaves.block[index(c)]) + 1];
    for (std::int64_t other = c + 1; other < end; ++other) {
      const bool anchored = anchor[index(c)] >= 0 || anchor[index(other)] >= 0;
      if (anchored) found.push_back(hubs.block[index(other)]);
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

SymmetricPattern FullSystem::pattern() const {
  SymmetricPattern pattern;
  for (std::int64_t a = 0; a < layout_.hubs; ++a) pattern.offset.push_back(a * layout_.hub_size);
  for (std::int64_t l = 0; l <= layout_.leaves; ++l) {
    pattern.offset.push_back(layout_.offset(Side::leaves) + l * layout_.leaf_size);
  }
  const Incidence& hubs = layout_.hub_side;
  pattern.row_begin.push_back(0);
  for (std::int64_t a = 0; a < layout_.hubs; ++a) {
    pattern.column.push_back(static_cast<std::int32_t>(a));
    const std::vector<std::int32_t> others = hub_neighbours(a);
    pattern.column.insert(pattern.column.end(), others.begin(), others.end());
    for (std::int64_t p = hubs.begin[index(a)]; p < hubs.begin[index(a + 1)]; ++p) {
      const std::int32_t leaf = layout_.leaf_side.block[index(hubs.list[index(p)])];
      pattern.column.push_back(static_cast<std::int32_t>(layout_.hubs) + leaf);
    }
    pattern.row_begin.push_back(static_cast<std::int64_t>(pattern.column.size()));
  }
  for (std::int64_t l = 0; l < layout_.leaves; ++l) {
    pattern.column.push_back(static_cast<std::int32_t>(layout_.hubs + l));
    pattern.row_begin.push_back(static_cast<std::int64_t>(pattern.column.size()));
  }
  return pattern;
}

void FullSystem::write_diagonal(SymmetricBlocks& A, Side side) const {
  const int size = layout_.block_size(side);
  std::vector<double> blocks;
  at_.normal->diagonal_blocks(*at_.J, side, blocks, pool_);
  const double* H = blocks.data();
  const double* d = damping_ + layout_.offset(side);
  const std::int64_t first = side == Side::hubs ? 0 : layout_.hubs;
  for (std::int64_t b = 0; b < layout_.block_count(side); ++b) {
    A.set_zero(first + b);
    for (int i = 0; i < size; ++i) {
      double* row = A.row(first + b) + i * A.stride(first + b);
      std::copy_n(H + (b * size + i) * size, size, row);
      row[i] += d[b * size + i];
    }
  }
}

EliminationView FullSystem::view() const {
  EliminationView view = {};
  view.kept = side_view(layout_, Side::hubs);
  view.J_kept = at_.J->blocks(Side::hubs);
  view.J_eliminated = at_.J->blocks(Side::leaves);
  return view;
}

void FullSystem::write_couplings(SymmetricBlocks& A) const {
  const EliminationKernels& kernels =
      elimination_kernels(kernel_shape(layout_, at_.J->precision()), true);
  const Incidence& hubs = layout_.hub_side;
  for_blocks(layout_, Side::hubs, pool_, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t a = first; a < last; ++a) {
      const std::int64_t couplings = hubs.begin[index(a + 1)] - hubs.begin[index(a)];
      std::int64_t block = A.pattern().row_begin[index(a + 1)] - couplings;  // the last of the row
      for (std::int64_t p = hubs.begin[index(a)]; p < hubs.begin[index(a + 1)]; ++p, ++block) {
        kernels.coupling(view(), hubs.list[index(p)], A.row(a) + A.block_shift(block), A.stride(a));
      }
    }
  });
}

// Row a, column b of A, scalar by scalar in row-major steps of the stride.
double* FullSystem::block(SymmetricBlocks& A, std::int64_t a, std::int64_t b) const {
  const SymmetricPattern& pattern = A.pattern();
  const auto first = pattern.column.begin() + pattern.row_begin[index(a)];
  const auto last = pattern.column.begin() + pattern.row_begin[index(a + 1)];
  const auto found = std::lower_bound(first, last, static_cast<std::int32_t>(b));
  return A.row(a) + A.block_shift(found - pattern.column.begin());
}

// With E and C of one leaf, what its anchors add beside the diagonal of B is, of hubs a < b,
//   E_a Z_b + Z_a^T E_b^T + Z_a^T C Z_b = F_a Z_b + Z_a^T F_b^T,  F = E + 1/2 Z^T C,
// and what they add to E is Z^T C.
void FullSystem::add_anchors(SymmetricBlocks& A) const {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  using Strided = Eigen::Map<Matrix, 0, Eigen::OuterStride<>>;
  const int hub = layout_.hub_size, leaf = layout_.leaf_size;
  const auto at = [&](std::int64_t a, std::int64_t b, int columns) {
    return Strided(block(A, a, b), hub, columns, Eigen::OuterStride<>(A.stride(a)));
  };
  std::vector<Matrix> F, Z;
  for (std::int64_t l = 0; layout_.anchored() && l < layout_.leaves; ++l) {
    const std::int64_t first = layout_.leaf_side.begin[index(l)];
    const std::int64_t last = layout_.leaf_side.begin[index(l + 1)];
    const Eigen::Map<const Matrix> C(at_.normal->C.data() + l * leaf * leaf, leaf, leaf);
    F.clear(), Z.clear();
    for (std::int64_t c = first; c < last; ++c) {
      const std::int64_t anchor = layout_.anchorage.anchor[index(c)];
      Z.push_back(Matrix::Zero(leaf, hub));
      if (anchor >= 0) {
        Z.back() =
            Eigen::Map<const Matrix>(at_.J->anchor_blocks.data() + anchor * leaf * hub, leaf, hub);
      }
      auto E = at(layout_.hub_side.block[index(c)], layout_.hubs + l, leaf);
      const Matrix ZC = Z.back().transpose() * C;
      F.push_back(E + 0.5 * ZC);
      E += ZC;
    }
    for (std::int64_t c = first; c < last; ++c) {
      for (std::int64_t other = c + 1; other < last; ++other) {
        const auto& anchor = layout_.anchorage.anchor;
        if (anchor[index(c)] < 0 && anchor[index(other)] < 0) continue;
        const std::size_t i = index(c - first), j = index(other - first);
        at(layout_.hub_side.block[index(c)], layout_.hub_side.block[index(other)], hub) +=
            F[i] * Z[j] + Z[i].transpose() * F[j].transpose();
      }
    }
  }
}

void FullSystem::assemble(SymmetricBlocks& A, double* v) {
  gradient(v);
  write_diagonal(A, Side::hubs);
  write_diagonal(A, Side::leaves);
  write_couplings(A);
  add_anchors(A);
}

void FullSystem::reduced_diagonal(DiagonalBlocks& out, double* v) {
  gradient(v);
  diagonal_blocks(out);
}

void FullSystem::diagonal_blocks(DiagonalBlocks& out) {
  out.runs.resize(2);
  std::size_t next = 0;
  for (const Side side : {Side::hubs, Side::leaves}) {
    const int size = layout_.block_size(side);
    DiagonalBlocks::Run& run = out.runs[next++];
    run.size = size;
    run.count = layout_.block_count(side);
    at_.normal->diagonal_blocks(*at_.J, side, run.values, pool_);
    const double* d = damping_ + layout_.offset(side);
    for (std::int64_t i = 0; i < run.count * size; ++i) {
      run.values[index(i * size + i % size)] += d[i];
    }
  }
}

}  // namespace raybundle::linalg
