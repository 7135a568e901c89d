#include <raybundle/linalg/schur_complement.h>

#include <raybundle/linalg/block_factor.h>
#include <raybundle/linalg/reduced_pattern.h>
#include <raybundle/linalg/vector.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <numeric>

namespace raybundle::linalg {
namespace {

// Of one block of a side.
std::int64_t most_rows(const BlockLayout& layout, Side side) {
  const Incidence& blocks = layout.incidence(side);
  const auto rows_of = [&](std::int64_t c) {
    const auto& begin = layout.coupling_rows;
    return begin.empty() ? 1 : begin[index(c + 1)] - begin[index(c)];
  };
  std::int64_t most = 0;
  for (std::int64_t b = 0; b < layout.block_count(side); ++b) {
    std::int64_t rows = 0;
    for (std::int64_t p = blocks.begin[index(b)]; p < blocks.begin[index(b + 1)]; ++p) {
      rows += rows_of(blocks.list.empty() ? p : blocks.list[index(p)]);
    }
    most = std::max(most, rows);
  }
  return most;
}

}  // namespace

SchurComplement::SchurComplement(const BlockLayout& layout, Side eliminated, ThreadPool& pool)
    : layout_(layout),
      pool_(pool),
      kept_(opposite(eliminated)),
      eliminated_(eliminated),
      M_(index(layout.size(eliminated) * layout.block_size(eliminated))),
      q_(index(layout.size(eliminated))) {
  const KernelShape shape = kernel_shape(layout, Precision::double_precision);
  static_cast<void>(elimination_kernels(shape, eliminated == Side::leaves));  // or throws
  most_residuals_ = layout.row_size * most_rows(layout, eliminated);
  scratch_.resize(index(max_chunks * most_residuals_));
  if (eliminated == Side::hubs) hub_positions_ = positions(layout.hub_side);
}

const EliminationKernels& SchurComplement::kernels() const {
  return elimination_kernels(kernel_shape(layout_, at_.J->precision()),
                             eliminated_ == Side::leaves);
}

double SchurComplement::memory(const LayoutSize& n, Side eliminated, bool assembled) {
  const double block = n.block_size(eliminated);
  const auto size = static_cast<double>(n.size(eliminated));
  const auto rows = static_cast<double>(n.rows), residuals = static_cast<double>(n.residuals());
  double bytes = 8 * (block * size + size);
  if (n.anchored() && assembled) bytes += 8.0 * n.block.hub * n.block.leaf * rows;
  if (eliminated == Side::hubs) bytes += 8 * block * size + 4 * rows;
  if (assembled) {
    const std::int64_t kept = n.block_count(opposite(eliminated));
    return bytes + 4 * static_cast<double>(chunks(kept, 1).pieces * kept);  // slots
  }
  if (eliminated == Side::hubs) return bytes + 8 * residuals;
  const int hub = n.block.hub, operand = operand_size(n.block.row, hub);
  return bytes + 8.0 * operand * static_cast<double>(n.hubs) + HubSums::memory(n, operand) +
         HubSums::memory(n, triangle_size(hub) + hub);
}

EliminationView SchurComplement::view() {
  SideView eliminated = side_view(layout_, eliminated_);
  if (eliminated_ == Side::hubs) eliminated.position = hub_positions_.data();
  return {side_view(layout_, kept_),
          eliminated,
          at_.J->blocks(kept_),
          at_.J->blocks(eliminated_),
          damping(eliminated_),
          M_.data(),
          q_.data(),
          W_.data(),
          at_.J->view().anchors};
}

void SchurComplement::prepare(const Linearization& at, const double* damping) {
  at_ = at;
  damping_ = damping;
  factor();
  const double* g = at_.normal->gradient.data() + layout_.offset(eliminated_);
  for_blocks(layout_, eliminated_, pool_, [&](std::int64_t first, std::int64_t last) {
    kernels().solve_own(view(), g, first, last);
  });
}

void SchurComplement::factor() {
  constexpr std::int64_t grain = 128;
  std::mutex mutex;
  std::vector<std::int64_t> deficient;
  if (eliminated_ == Side::hubs) {
    at_.normal->diagonal_blocks(*at_.J, eliminated_, hub_blocks_, pool_);
  }
  const double* H = eliminated_blocks();
  parallel_for(
      pool_, layout_.block_count(eliminated_), grain, [&](std::int64_t first, std::int64_t last) {
        std::array<std::int64_t, grain> failed;
        for (; first < last; first += grain) {
          const std::int64_t end = std::min(last, first + grain);
          const std::int64_t count = kernels().factor(H, damping(eliminated_), pivot_tolerance,
                                                      first, end, M_.data(), failed.data());
          if (count == 0) continue;
          const std::lock_guard lock(mutex);
          deficient.insert(deficient.end(), failed.begin(), failed.begin() + count);
        }
      });
  factor_deficient(deficient);
}

const double* SchurComplement::eliminated_blocks() const {
  return eliminated_ == Side::hubs ? hub_blocks_.data() : at_.normal->C.data();
}

void SchurComplement::factor_deficient(const std::vector<std::int64_t>& blocks) {
  deficient_blocks_ = static_cast<std::int64_t>(blocks.size());
  const int size = layout_.block_size(eliminated_);
  parallel_for(pool_, deficient_blocks_, 16, [&](std::int64_t first, std::int64_t last) {
    for (std::array<double, 144> A; first < last; ++first) {
      const std::int64_t e = blocks[index(first)];
      std::copy_n(eliminated_blocks() + e * size * size, size * size, A.begin());
      for (int i = 0; i < size; ++i) A[index(i * size + i)] += damping(eliminated_)[e * size + i];
      pseudo_inverse_factor(A.data(), size, M_.data() + e * size * size);
    }
  });
}

const double* SchurComplement::own_gradient() const {
  return kept_ == Side::hubs ? at_.normal->own_hub_gradient()
                             : at_.normal->gradient.data() + offset();
}

void SchurComplement::gradient(double* v) {
  std::copy_n(own_gradient(), size(), v);
  for_blocks(layout_, kept_, pool_, [&](std::int64_t first, std::int64_t last) {
    kernels().reduce_gradient(view(), first, last, v);
  });
}

void SchurComplement::apply(const double* x, double* y) {
  if (kept_ == Side::hubs) {
    apply_to_hubs(x, y);
  } else {
    apply_to_leaves(x, y);
  }
}

void SchurComplement::apply_to_hubs(const double* x, double* y) {
  const int size = layout_.hub_size;
  const int spread = in_pairs(layout_.row_size) ? 2 : 1;
  const std::int64_t stride = operand_size(layout_.row_size, size);
  operand_.resize(index(layout_.hubs * stride));
  for_hubs([&](std::int64_t hub, int i) {
    for (int k = 0; k < spread; ++k) {
      operand_[index(hub * stride + i * spread + k)] = x[hub * size + i];
    }
  });
  const double* sums = product_sums_.form(
      layout_, stride, pool_,
      [&](std::int64_t first, std::int64_t last, std::int64_t piece, double* part) {
        kernels().multiply(view(), operand_.data(), first, last, scratch(piece), part);
      });
  const double* d = damping(kept_);
  for_hubs([&](std::int64_t hub, int i) {
    const double* sum = sums + hub * stride + i * spread;
    const std::int64_t at = hub * size + i;
    y[at] = d[at] * x[at] + std::accumulate(sum, sum + spread, 0.0);
  });
}

// Calls update(hub, number of its unknown), in parallel.
template <class Update>
void SchurComplement::for_hubs(Update&& update) {
  parallel_for(pool_, layout_.hubs, 1024, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t hub = first; hub < last; ++hub) {
      for (int i = 0; i < layout_.hub_size; ++i) update(hub, i);
    }
  });
}

void SchurComplement::apply_to_leaves(const double* x, double* y) {
  rows_.resize(index(layout_.residuals()));
  for_blocks(layout_, eliminated_, pool_, [&](std::int64_t first, std::int64_t last) {
    kernels().project(view(), x, first, last, rows_.data());
  });
  transpose_multiply_leaves(*at_.J, rows_.data(), y, pool_);
  const double* d = damping(kept_);
  for_entries(size(), pool_, [&](std::size_t i) { y[i] += d[i] * x[i]; });
}

double SchurComplement::expand(const double* x, double* step) {
  std::copy_n(x, size(), step + offset());
  double* x_eliminated = step + layout_.offset(eliminated_);
  const Chunks pieces =
      chunks(layout_.block_count(eliminated_), eliminated_ == Side::hubs ? 1 : 128);
  std::array<double, max_chunks> squares = {};
  pool_.run(pieces.pieces, [&](std::int64_t piece) {
    squares[index(piece)] = kernels().back_substitute(
        view(), x, pieces.begin(piece), pieces.end(piece), scratch(piece), x_eliminated);
  });
  return std::accumulate(squares.begin(), squares.end(), 0.0);
}

SymmetricPattern SchurComplement::pattern() const {
  return reduced_pattern(layout_, eliminated_, pool_);
}

// What block row a has without its rows: D_a, and v_a = g_a.
void SchurComplement::start_row(SymmetricBlocks& A, std::int64_t a, double* v) const {
  const int size = layout_.block_size(kept_);
  A.set_zero(a);
  for (int i = 0; i < size; ++i) A.row(a)[i * A.stride(a) + i] = damping(kept_)[a * size + i];
  std::copy_n(own_gradient() + a * size, size, v + a * size);
}

void SchurComplement::assemble(SymmetricBlocks& A, double* v) {
  if (layout_.anchored()) {
    W_.resize(index(layout_.couplings * layout_.hub_size * layout_.leaf_size));
    for_blocks(layout_, eliminated_, pool_, [&](std::int64_t first, std::int64_t last) {
      kernels().couple(view(), first, last);
    });
  }
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
      kernels().add_products(view(), a, row, v);
    }
  });
}

void SchurComplement::diagonal_blocks(DiagonalBlocks& out) {
  start_diagonal(out);
  std::vector<double>& H = out.runs.front().values;
  at_.normal->diagonal_blocks(*at_.J, kept_, H, pool_);
  damp_diagonal(out);
}

void SchurComplement::reduced_diagonal(DiagonalBlocks& out, double* v) {
  start_diagonal(out);
  std::vector<double>& A = out.runs.front().values;
  if (kept_ == Side::hubs) {
    reduced_diagonal_of_hubs(A.data(), v);
  } else {
    gradient(v);
    for_blocks(layout_, kept_, pool_, [&](std::int64_t first, std::int64_t last) {
      kernels().diagonal_blocks(view(), first, last, A.data());
    });
  }
  damp_diagonal(out);
}

void SchurComplement::reduced_diagonal_of_hubs(double* A, double* v) {
  const int size = layout_.hub_size;
  const int triangle = triangle_size(size);
  const double* sums =
      diagonal_sums_.form(layout_, triangle + size, pool_,
                          [&](std::int64_t first, std::int64_t last, std::int64_t /*piece*/,
                              double* part) { kernels().add_diagonal(view(), first, last, part); });
  const double* g = own_gradient();
  for (std::int64_t a = 0; a < layout_.hubs; ++a, sums += triangle + size) {
    for (int i = 0; i < size; ++i, ++g) {
      const double* row = sums + triangle_begin(size, i);
      for (int j = 0; j <= i; ++j) A[i * size + j] = A[j * size + i] = row[j];
      *v++ = *g + sums[triangle + i];
    }
    A += size * size;
  }
}

void SchurComplement::start_diagonal(DiagonalBlocks& out) const {
  out.runs.resize(1);
  DiagonalBlocks::Run& run = out.runs.front();
  run.size = layout_.block_size(kept_);
  run.count = layout_.block_count(kept_);
  run.values.resize(index(run.count * run.size * run.size));
}

void SchurComplement::damp_diagonal(DiagonalBlocks& out) const {
  DiagonalBlocks::Run& run = out.runs.front();
  const double* d = damping(kept_);
  for (std::int64_t i = 0; i < run.count * run.size; ++i) {
    run.values[index(i * run.size + i % run.size)] += d[i];
  }
}

}  // namespace raybundle::linalg
