#include <raybundle/linalg/schur_complement.h>

#include <raybundle/linalg/block_factor.h>
#include <raybundle/linalg/memory.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <string>

namespace raybundle::linalg {

SchurComplement::SchurComplement(const BlockLayout& layout, Side eliminated, ThreadPool& pool)
    : layout_(layout),
      pool_(pool),
      kept_(opposite(eliminated)),
      eliminated_(eliminated),
      kernels_(elimination_kernels(layout, eliminated)),
      M_(index(layout.size(eliminated) * layout.block_size(eliminated))),
      U_(index(layout.residuals() * layout.block_size(eliminated))),
      y_(index(layout.size(eliminated))) {
  if (!layout.anchored()) return;
  W_.resize(index(layout.couplings * layout.hub_size * layout.leaf_size));
  leaves_.resize(index(layout.size(Side::leaves)));
}

EliminationView SchurComplement::view() {
  return {side_view(layout_, kept_),
          side_view(layout_, eliminated_),
          at_.J->blocks(kept_),
          at_.J->blocks(eliminated_),
          damping(eliminated_),
          M_.data(),
          U_.data(),
          y_.data(),
          W_.data(),
          anchor_view(*at_.J)};
}

void SchurComplement::prepare(const Linearization& at, const double* damping) {
  at_ = at;
  damping_ = damping;
  factor();
  transform();
}

void SchurComplement::factor() {
  constexpr std::int64_t grain = 128;
  std::mutex mutex;
  std::vector<std::int64_t> deficient;
  const double* H = at_.normal->blocks(eliminated_);
  parallel_for(
      pool_, layout_.block_count(eliminated_), grain, [&](std::int64_t first, std::int64_t last) {
        std::array<std::int64_t, grain> failed;
        for (; first < last; first += grain) {
          const std::int64_t end = std::min(last, first + grain);
          const std::int64_t count = kernels_.factor(H, damping(eliminated_), pivot_tolerance,
                                                     first, end, M_.data(), failed.data());
          if (count == 0) continue;
          const std::lock_guard lock(mutex);
          deficient.insert(deficient.end(), failed.begin(), failed.begin() + count);
        }
      });
  factor_deficient(deficient);
}

void SchurComplement::factor_deficient(const std::vector<std::int64_t>& blocks) {
  deficient_blocks_ = static_cast<std::int64_t>(blocks.size());
  const int size = layout_.block_size(eliminated_);
  std::array<double, 144> A;
  for (const std::int64_t e : blocks) {
    std::copy_n(at_.normal->blocks(eliminated_) + e * size * size, size * size, A.begin());
    for (int i = 0; i < size; ++i) A[index(i * size + i)] += damping(eliminated_)[e * size + i];
    pseudo_inverse_factor(A.data(), size, M_.data() + e * size * size);
  }
}

void SchurComplement::transform() {
  const double* g = at_.normal->gradient.data() + layout_.offset(eliminated_);
  for_blocks(layout_, eliminated_, pool_, [&](std::int64_t first, std::int64_t last) {
    kernels_.transform(view(), g, first, last);
  });
}

const double* SchurComplement::own_gradient() const {
  return kept_ == Side::hubs ? at_.normal->own_hub_gradient()
                             : at_.normal->gradient.data() + offset();
}

void SchurComplement::gradient(double* v) {
  std::copy_n(own_gradient(), size(), v);
  for_blocks(layout_, kept_, pool_, [&](std::int64_t first, std::int64_t last) {
    kernels_.reduce_gradient(view(), first, last, v);
  });
}

void SchurComplement::apply(const double* x, double* y) {
  rows_.resize(index(layout_.residuals()));
  for_blocks(layout_, eliminated_, pool_, [&](std::int64_t first, std::int64_t last) {
    kernels_.project(view(), x, first, last, rows_.data(), leaves_.data());
  });
  if (kept_ == Side::hubs) {
    transpose_multiply_hubs(*at_.J, rows_.data(), leaves_.data(), y, pool_);
  } else {
    transpose_multiply_leaves(*at_.J, rows_.data(), y, pool_);
  }
  const double* d = damping(kept_);
  for (std::int64_t i = 0; i < size(); ++i) y[i] += d[i] * x[i];
}

void SchurComplement::expand(const double* x, double* step) {
  std::copy_n(x, size(), step + offset());
  double* x_eliminated = step + layout_.offset(eliminated_);
  for_blocks(layout_, eliminated_, pool_, [&](std::int64_t first, std::int64_t last) {
    kernels_.back_substitute(view(), x, first, last, x_eliminated);
  });
}

// Calls visit(b) once for every kept b > a that shares an eliminated block with a; seen[b] is a
// mark that must be different from a before.
template <class Visit>
void SchurComplement::for_neighbours(std::int64_t a, std::vector<std::int64_t>& seen,
                                     Visit&& visit) const {
  const Incidence& kept = layout_.incidence(kept_);
  const Incidence& eliminated = layout_.incidence(eliminated_);
  seen[index(a)] = a;
  for (std::int64_t p = kept.begin[index(a)]; p < kept.begin[index(a + 1)]; ++p) {
    const std::int64_t c = kept.list.empty() ? p : kept.list[index(p)];
    const std::int64_t start = eliminated.position.empty() ? c : eliminated.position[index(c)];
    const std::int64_t end = eliminated.begin[index(eliminated.block[index(c)]) + 1];
    for (std::int64_t q = start; q < end; ++q) {
      const std::int64_t other = eliminated.list.empty() ? q : eliminated.list[index(q)];
      const std::int32_t b = kept.block[index(other)];
      if (seen[index(b)] == a) continue;
      seen[index(b)] = a;
      visit(b);
    }
  }
}

// A reduced matrix can have the square of the kept blocks. Where it may be large its blocks are
// counted before any is stored: what cannot be held is refused here and not half-way.
void SchurComplement::require_pattern_memory() const {
  const Incidence& eliminated = layout_.incidence(eliminated_);
  const std::int64_t count = layout_.block_count(kept_);
  double blocks = 0;
  for (std::int64_t e = 0; e < layout_.block_count(eliminated_); ++e) {
    const auto degree =
        static_cast<double>(eliminated.begin[index(e + 1)] - eliminated.begin[index(e)]);
    blocks += degree * (degree + 1) / 2;
  }
  constexpr double few = 1e7;
  if (blocks > few) {
    blocks = static_cast<double>(count);
    std::vector<std::int64_t> seen(index(count), -1);
    for (std::int64_t a = 0; a < count; ++a) {
      for_neighbours(a, seen, [&](std::int32_t) { ++blocks; });
    }
  }
  // The least that any factorisation takes: a full matrix in dense storage, with its workspace, has
  // 24 bytes per entry of the triangle (dense_cholesky.h); sparse storage has more.
  const double entries = static_cast<double>(layout_.block_size(kept_)) * layout_.block_size(kept_);
  require_memory(blocks * (24 * entries + 12),
                 "the reduced matrix of " + std::to_string(count) + " blocks");
}

SymmetricPattern SchurComplement::pattern() const {
  require_pattern_memory();
  SymmetricPattern pattern;
  const std::int64_t count = layout_.block_count(kept_);
  for (std::int64_t a = 0; a <= count; ++a) {
    pattern.offset.push_back(a * layout_.block_size(kept_));
  }
  std::vector<std::int64_t> seen(index(count), -1);
  pattern.row_begin.push_back(0);
  for (std::int64_t a = 0; a < count; ++a) {
    pattern.column.push_back(static_cast<std::int32_t>(a));
    for_neighbours(a, seen, [&](std::int32_t b) { pattern.column.push_back(b); });
    std::sort(pattern.column.begin() + pattern.row_begin.back(), pattern.column.end());
    pattern.row_begin.push_back(static_cast<std::int64_t>(pattern.column.size()));
  }
  return pattern;
}

// What block row a has by its own rows, H_aa + D_a, and v_a = g_a.
void SchurComplement::start_row(SymmetricBlocks& A, std::int64_t a, double* v) const {
  const int size = layout_.block_size(kept_);
  const double* H = at_.normal->blocks(kept_) + a * size * size;
  const double* d = damping(kept_) + a * size;
  const double* g = own_gradient() + a * size;
  A.set_zero(a);
  for (int i = 0; i < size; ++i) {
    double* row = A.row(a) + i * A.stride(a);
    std::copy_n(H + i * size, size, row);
    row[i] += d[i];
    v[a * size + i] = g[i];
  }
}

void SchurComplement::assemble(SymmetricBlocks& A, double* v) {
  const SymmetricPattern& pattern = A.pattern();
  const std::int64_t count = layout_.block_count(kept_);
  const Chunks pieces = chunks(count, 1);
  slot_.resize(index(pieces.pieces * count));
  pool_.run(pieces.pieces, [&](std::int64_t piece) {
    std::int32_t* slot = slot_.data() + piece * count;
    for (std::int64_t a = pieces.begin(piece); a < pieces.end(piece); ++a) {
      for (std::int64_t p = pattern.row_begin[index(a)]; p < pattern.row_begin[index(a + 1)]; ++p) {
        slot[pattern.column[index(p)]] =
            static_cast<std::int32_t>(A.block_shift(p) / layout_.block_size(kept_));
      }
      const BlockRowView row = {A.row(a), A.stride(a), slot};
      start_row(A, a, v);
      kernels_.subtract_products(view(), a, row, v);
    }
  });
}

void SchurComplement::diagonal_blocks(Blocks which, DiagonalBlocks& out) {
  const int size = layout_.block_size(kept_);
  const std::int64_t count = layout_.block_count(kept_);
  out.runs.resize(1);
  DiagonalBlocks::Run& run = out.runs.front();
  run.size = size;
  run.count = count;
  if (which == Blocks::undiminished) {
    at_.normal->diagonal_blocks(*at_.J, kept_, run.values, pool_);
  } else {
    run.values.resize(index(count * size * size));
    for_blocks(layout_, kept_, pool_, [&](std::int64_t first, std::int64_t last) {
      kernels_.diagonal_blocks(view(), at_.normal->blocks(kept_), first, last, run.values.data());
    });
  }
  const double* d = damping(kept_);
  for (std::int64_t a = 0; a < count; ++a) {
    for (int i = 0; i < size; ++i) {
      run.values[index((a * size + i) * size + i)] += d[a * size + i];
    }
  }
}

}  // namespace raybundle::linalg
