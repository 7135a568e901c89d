#include <raybundle/linalg/full_system.h>

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

void FullSystem::expand(const double* x, double* step) { std::copy_n(x, size(), step); }

// The hubs after a that have parts of the same rows.
std::vector<std::int32_t> FullSystem::hub_neighbours(std::int64_t a) const {
  std::vector<std::int32_t> found;
  if (!layout_.several_parts()) return found;
  const RowParts& parts = layout_.parts;
  const Incidence& hubs = layout_.hub_side;
  for (std::int64_t p = hubs.begin[index(a)]; p < hubs.begin[index(a + 1)]; ++p) {
    const std::int64_t c = hubs.list[index(p)];
    for (std::int64_t k = parts.coupling_begin[index(c)]; k < parts.coupling_begin[index(c + 1)];
         ++k) {
      const std::int64_t part = parts.list[index(k)];
      const std::int64_t end = parts.row_parts[index(parts.row[index(part)]) + 1];
      found.insert(found.end(), parts.hub.begin() + part + 1, parts.hub.begin() + end);
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
  const double* H = at_.normal->blocks(side);
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
  const EliminationKernels& kernels = elimination_kernels(layout_, Side::leaves);
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

void FullSystem::add_hub_products(SymmetricBlocks& A) const {
  const EliminationKernels& kernels = elimination_kernels(layout_, Side::leaves);
  if (kernels.add_products == nullptr) return;
  const SymmetricPattern& pattern = A.pattern();
  std::vector<std::int32_t> slot(index(layout_.hubs));
  for (std::int64_t a = 0; a < layout_.hubs; ++a) {
    for (std::int64_t p = pattern.row_begin[index(a)]; p < pattern.row_begin[index(a + 1)]; ++p) {
      const std::int32_t b = pattern.column[index(p)];
      if (b >= layout_.hubs) break;
      slot[index(b)] = static_cast<std::int32_t>(A.block_shift(p) / layout_.hub_size);
    }
    kernels.add_products(view(), a, {A.row(a), A.stride(a), slot.data()});
  }
}

void FullSystem::assemble(SymmetricBlocks& A, double* v) {
  gradient(v);
  write_diagonal(A, Side::hubs);
  write_diagonal(A, Side::leaves);
  write_couplings(A);
  add_hub_products(A);
}

void FullSystem::diagonal_blocks(Blocks /*which: nothing is eliminated*/, DiagonalBlocks& out) {
  out.runs.resize(2);
  std::size_t next = 0;
  for (const Side side : {Side::hubs, Side::leaves}) {
    const int size = layout_.block_size(side);
    DiagonalBlocks::Run& run = out.runs[next++];
    run.size = size;
    run.count = layout_.block_count(side);
    const double* H = at_.normal->blocks(side);
    run.values.assign(H, H + run.count * size * size);
    const double* d = damping_ + layout_.offset(side);
    for (std::int64_t i = 0; i < run.count * size; ++i) {
      run.values[index(i * size + i % size)] += d[i];
    }
  }
}

}  // namespace raybundle::linalg
