#include <raybundle/linalg/supernodal_cholesky.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>

namespace raybundle::linalg {
namespace {

constexpr std::int64_t alignment = 64;  // bytes
constexpr std::int64_t tile_strips = 8;

constexpr std::int64_t padded(std::int64_t numbers) {
  constexpr std::int64_t line = alignment / 8;
  return ceil_div(numbers, line) * line;
}

double* aligned(double* p) {
  const auto address = reinterpret_cast<std::uintptr_t>(p);
  return p + (alignment - address % alignment) % alignment / sizeof(double);
}

// Into a packed triangle or rows: where row `row` of column 0 stands.
double* row_of_triangle(const PackedTriangle& L, std::int64_t strip, std::int64_t row) {
  return L.values + packed_size(row / strip, strip) + row % strip;
}

}  // namespace

SupernodalCholesky::SupernodalCholesky(const SymmetricPattern& pattern, Supernodes supernodes,
                                       ThreadPool& pool, InstructionSet set)
    : pool_(pool),
      kernels_(dense_kernels(set)),
      supernodes_(std::move(supernodes)),
      layout_(supernodes_, kernels_.strip, kernels_.step, pool.threads()),
      tiled_(kernels_, layout_.most_strips) {
  find_entries(pattern);
  const std::int64_t lanes = layout_.subtrees.empty() ? 0 : pool.threads();
  const std::int64_t factor = padded(layout_.factor_size), pivots = padded(layout_.pivots_size),
                     shared = padded(layout_.shared_size), lane = padded(layout_.lane_size);
  storage_.resize(index(factor + pivots + shared + lanes * lane + alignment / 8));
  values_ = aligned(storage_.data());
  pivots_ = values_ + factor;
  shared_ = pivots_ + pivots;
  lanes_ = shared_ + shared;
  std::int64_t tallest = 0;
  for (const auto& front : layout_.fronts) tallest = std::max(tallest, front.rows_strips);
  for (const std::int32_t a : supernodes_.order) begin_.push_back(pattern.offset[index(a)]);
  x_.resize(index(pattern.order()));
  own_.resize(index(layout_.most_strips * kernels_.strip));
  below_.resize(index(tallest * kernels_.strip));
}

double SupernodalCholesky::memory(const SymmetricPattern& pattern, const Supernodes& supernodes,
                                  int threads) {
  const FrontLayout layout(supernodes, widest_strip, widest_step, threads);
  const double numbers =
      static_cast<double>(layout.factor_size) + static_cast<double>(layout.pivots_size) +
      static_cast<double>(layout.shared_size) +
      static_cast<double>(layout.subtrees.empty() ? 0 : threads * layout.lane_size);
  const double blocks = sizeof(Entry) * static_cast<double>(pattern.column.size());
  return 8 * (numbers + static_cast<double>(pattern.scalar_nonzeros())) + blocks +
         4 * static_cast<double>(layout.target.size());
}

void SupernodalCholesky::find_entries(const SymmetricPattern& pattern) {
  const Supernodes& s = supernodes_;
  std::vector<std::int32_t> owner(s.order.size());
  for (std::int32_t f = 0; f < s.count(); ++f) {
    std::fill(owner.begin() + s.first[index(f)], owner.begin() + s.first[index(f + 1)], f);
  }
  const auto first_place = [&](std::int64_t a, std::int64_t p) {
    return std::min(s.place[index(a)], s.place[index(pattern.column[index(p)])]);
  };
  const auto for_blocks = [&](auto&& visit) {
    for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
      for (std::int64_t p = pattern.row_begin[index(a)]; p < pattern.row_begin[index(a + 1)]; ++p) {
        visit(static_cast<std::int32_t>(a), p, owner[index(first_place(a, p))]);
      }
    }
  };
  entry_begin_.assign(index(s.count() + 1), 0);
  for_blocks([&](std::int32_t, std::int64_t, std::int32_t f) { ++entry_begin_[index(f + 1)]; });
  for (std::int32_t f = 0; f < s.count(); ++f) entry_begin_[index(f + 1)] += entry_begin_[index(f)];
  entries_.resize(pattern.column.size());
  std::vector<std::int64_t> next = entry_begin_;
  for_blocks([&](std::int32_t a, std::int64_t p, std::int32_t f) {
    entries_[index(next[index(f)]++)] = {p, a, 0, 0};
  });

  std::vector<std::int32_t> local(s.order.size());  // of a place in a front
  for (std::int32_t f = 0; f < s.count(); ++f) {
    const std::int64_t begin = s.offset[index(s.first[index(f)])];
    for (std::int32_t k = s.first[index(f)]; k < s.first[index(f + 1)]; ++k) {
      local[index(k)] = static_cast<std::int32_t>(s.offset[index(k)] - begin);
    }
    std::int64_t below = layout_.fronts[index(f)].width;
    for (std::int64_t p = s.row_begin[index(f)]; p < s.row_begin[index(f + 1)]; ++p) {
      const std::int32_t k = s.row[index(p)];
      local[index(k)] = static_cast<std::int32_t>(below);
      below += s.offset[index(k + 1)] - s.offset[index(k)];
    }
    for (std::int64_t e = entry_begin_[index(f)]; e < entry_begin_[index(f + 1)]; ++e) {
      Entry& entry = entries_[index(e)];
      const std::int32_t b = pattern.column[index(entry.position)];
      entry.row = local[index(s.place[index(entry.block_row)])];
      entry.column = local[index(s.place[index(b)])];
    }
  }
}

PackedTriangle SupernodalCholesky::triangle(const FrontLayout::Front& front) const {
  double* const pivots = pivots_ + front.pivots;
  return {front.width, values_ + front.values, pivots, pivots + front.strips * kernels_.strip};
}

PackedRows SupernodalCholesky::rows(const FrontLayout::Front& front) const {
  return {front.columns, values_ + front.values + packed_size(front.strips, kernels_.strip)};
}

double* SupernodalCholesky::kept(std::int32_t s, double* lane_arena) const {
  const FrontLayout::Front& front = layout_.fronts[index(s)];
  double* const arena = front.shared ? shared_ : lane_arena;
  const std::int64_t size = front.shared ? layout_.shared_size : layout_.lane_size;
  return arena + (front.kept >= 0 ? front.kept : size + front.kept);
}

bool SupernodalCholesky::factor(const SymmetricBlocks& A) {
  failed_.store(false, std::memory_order_relaxed);
  // A lane takes the next subtree when it is done with one; which does not matter to the numbers.
  const auto subtrees = static_cast<std::int64_t>(layout_.subtrees.size());
  std::atomic<std::int64_t> next{0};
  pool_.run(subtrees == 0 ? 0 : pool_.threads(), [&](std::int64_t lane) {
    double* const arena = lanes_ + lane * padded(layout_.lane_size);
    for (std::int64_t t = next++; t < subtrees; t = next++) {
      factor_subtree(A, layout_.subtrees[index(t)], arena);
    }
  });
  for (const std::int32_t s : layout_.top) {
    if (failed_.load(std::memory_order_relaxed)) return false;
    if (!factor_front(A, {s, nullptr, false})) return false;
  }
  return !failed_.load(std::memory_order_relaxed);
}

void SupernodalCholesky::factor_subtree(const SymmetricBlocks& A,
                                        const FrontLayout::Subtree& subtree, double* arena) {
  for (std::int32_t s = subtree.first; s <= subtree.last; ++s) {
    if (failed_.load(std::memory_order_relaxed)) return;
    if (!factor_front(A, {s, arena, true})) failed_.store(true, std::memory_order_relaxed);
  }
}

bool SupernodalCholesky::factor_front(const SymmetricBlocks& A, const Task& task) {
  const FrontLayout::Front& front = layout_.fronts[index(task.front)];
  clear(task);
  add_matrix(A, task);
  for (std::int32_t c = layout_.child_begin[index(task.front)];
       c < layout_.child_begin[index(task.front + 1)]; ++c) {
    add_child(layout_.child[index(c)], task);
  }
  const PackedTriangle L = triangle(front);
  const bool positive =
      task.alone ? kernels_.factor(L, {0, front.strips}, 0) : tiled_.factor(L, pool_);
  if (!positive) return false;
  const PackedRows R = rows(front);
  for_pieces(task, front.rows_strips, tile_strips, [&](std::int64_t first, std::int64_t last) {
    kernels_.solve_rows(L, R, {first, last});
  });
  subtract_squares(task);
  return true;
}

// Pieces of `grain` strips, shared out where all lanes are here and the front is worth it.
template <class Body>
void SupernodalCholesky::for_pieces(const Task& task, std::int64_t count, std::int64_t grain,
                                    Body&& body) {
  const std::int64_t pieces = ceil_div(count, grain);
  const auto piece = [&](std::int64_t i) { body(i * grain, std::min(count, (i + 1) * grain)); };
  if (task.alone || pieces == 1) {
    for (std::int64_t i = 0; i < pieces; ++i) piece(i);
  } else {
    pool_.run(pieces, piece);
  }
}

void SupernodalCholesky::clear(const Task& task) {
  const FrontLayout::Front& front = layout_.fronts[index(task.front)];
  constexpr std::int64_t grain = 1 << 15;
  const std::int64_t strip = kernels_.strip;
  const auto zero = [&](double* values, std::int64_t size) {
    for_pieces(task, size, grain, [&](std::int64_t first, std::int64_t last) {
      std::fill(values + first, values + last, 0.0);
    });
  };
  zero(values_ + front.values,
       packed_size(front.strips, strip) + front.rows_strips * strip * front.columns);
  zero(kept(task.front, task.arena), packed_size(front.rows_strips, strip));
  const PackedTriangle L = triangle(front);
  for (std::int64_t k = front.width; k < front.columns; ++k) {
    row_of_triangle(L, strip, k)[k * strip] = 1;
  }
  std::fill_n(pivots_ + front.pivots, 2 * front.strips * strip, 0.0);
}

void SupernodalCholesky::add_matrix(const SymmetricBlocks& A, const Task& task) {
  const FrontLayout::Front& front = layout_.fronts[index(task.front)];
  const std::int64_t begin = entry_begin_[index(task.front)];
  const std::int64_t end = entry_begin_[index(task.front + 1)];
  for_pieces(task, end - begin, 256, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t e = begin + first; e < begin + last; ++e) {
      add_block(A, front, entries_[index(e)]);
    }
  });
}

// Row i of the block is column i of the triangle, or the other way round where the order has
// turned the two; diagonal blocks come with their thresholds.
void SupernodalCholesky::add_block(const SymmetricBlocks& A, const FrontLayout::Front& front,
                                   const Entry& entry) {
  const SymmetricPattern& pattern = A.pattern();
  const std::int64_t a = entry.block_row, b = pattern.column[index(entry.position)];
  const std::int64_t stride = A.stride(a), strip = kernels_.strip;
  const double* values = A.row(a) + A.block_shift(entry.position);
  const std::int64_t height = pattern.block_size(a), width = pattern.block_size(b);
  const bool turned = entry.row > entry.column;
  const std::int64_t top = std::max(entry.row, entry.column);
  const std::int64_t left = std::min(entry.row, entry.column);
  for (std::int64_t i = 0; i < (turned ? height : width); ++i) {
    double* to = entry_at(front, top + i, left);
    for (std::int64_t j = 0; j < (turned ? width : height); ++j, to += strip) {
      if (top + i < left + j) break;
      *to = turned ? values[i * stride + j] : values[j * stride + i];
    }
  }
  if (a != b) return;
  const double tolerance =
      static_cast<double>(pattern.order()) * std::numeric_limits<double>::epsilon();
  double* threshold = pivots_ + front.pivots + front.strips * strip + entry.column;
  for (std::int64_t i = 0; i < height; ++i) threshold[i] = tolerance * values[i * (stride + 1)];
}

// Of the columns that are eliminated in the front.
double* SupernodalCholesky::entry_at(const FrontLayout::Front& front, std::int64_t row,
                                     std::int64_t column) const {
  const std::int64_t strip = kernels_.strip;
  if (row < front.width) return row_of_triangle(triangle(front), strip, row) + column * strip;
  const PackedRows R = rows(front);
  const std::int64_t below = row - front.width;
  return R.values + below / strip * strip * R.columns + below % strip + column * strip;
}

// Adds C of a child, strip by strip: nobody else adds to the rows of a strip.
void SupernodalCholesky::add_child(std::int32_t child, const Task& task) {
  const FrontLayout::Front& from = layout_.fronts[index(child)];
  const FrontLayout::Front& front = layout_.fronts[index(task.front)];
  const std::int64_t strip = kernels_.strip, width = front.width;
  const std::int32_t* target = layout_.target.data() + from.target;
  const double* C = kept(child, task.arena);
  const PackedTriangle rest = {front.height, kept(task.front, task.arena), nullptr, nullptr};
  const std::int64_t eliminated = std::lower_bound(target, target + from.height, width) - target;
  for_pieces(task, from.rows_strips, 2, [&](std::int64_t first, std::int64_t last) {
    std::array<double*, widest_strip> of_front, of_rest;  // rows, column 0
    for (std::int64_t p = first; p < last; ++p) {
      const std::int64_t top = p * strip;
      const std::int64_t height = std::min(strip, from.height - top);
      for (std::int64_t r = 0; r < height; ++r) {
        const std::int64_t row = target[top + r];
        of_front[index(r)] = entry_at(front, row, 0);
        if (row >= width) of_rest[index(r)] = row_of_triangle(rest, strip, row - width);
      }
      const double* column = C + packed_size(p, strip);
      for (std::int64_t c = 0; c < top + height; ++c, column += strip) {
        const bool in_front = c < eliminated;
        const std::int64_t shift = (in_front ? target[c] : target[c] - width) * strip;
        double* const* to = in_front ? of_front.data() : of_rest.data();
        for (std::int64_t r = std::max<std::int64_t>(0, c - top); r < height; ++r) {
          to[r][shift] += column[r];
        }
      }
    }
  });
}

void SupernodalCholesky::subtract_squares(const Task& task) {
  const FrontLayout::Front& front = layout_.fronts[index(task.front)];
  const PackedTriangle C = {front.height, kept(task.front, task.arena), nullptr, nullptr};
  const PackedRows R = rows(front);
  const std::int64_t tiles = ceil_div(front.rows_strips, tile_strips);
  const auto strips = [&](std::int64_t tile) {
    return StripRange{tile * tile_strips, std::min(front.rows_strips, (tile + 1) * tile_strips)};
  };
  for_pieces(task, tiles * (tiles + 1) / 2, 1, [&](std::int64_t first, std::int64_t /*last*/) {
    std::int64_t row = 0, column = first;
    while (column > row) column -= ++row;
    kernels_.subtract_squares(C, R, strips(row), strips(column));
  });
}

void SupernodalCholesky::solve(double* x) {
  const Supernodes& s = supernodes_;
  for (std::size_t k = 0; k < s.order.size(); ++k) {
    std::copy_n(x + begin_[k], s.offset[k + 1] - s.offset[k], x_.data() + s.offset[k]);
  }
  for (std::int32_t f = 0; f < s.count(); ++f) forward(f);
  for (std::int32_t f = s.count() - 1; f >= 0; --f) backward(f);
  for (std::size_t k = 0; k < s.order.size(); ++k) {
    std::copy_n(x_.data() + s.offset[k], s.offset[k + 1] - s.offset[k], x + begin_[k]);
  }
}

// Calls visit(place in x, place below) for the runs of rows of a front.
template <class Visit>
void SupernodalCholesky::for_rows(std::int32_t f, Visit&& visit) const {
  const Supernodes& s = supernodes_;
  std::int64_t below = 0;
  for (std::int64_t p = s.row_begin[index(f)]; p < s.row_begin[index(f + 1)]; ++p) {
    const std::int32_t k = s.row[index(p)];
    for (std::int64_t i = s.offset[index(k)]; i < s.offset[index(k + 1)]; ++i) visit(i, below++);
  }
}

void SupernodalCholesky::forward(std::int32_t f) {
  const FrontLayout::Front& front = layout_.fronts[index(f)];
  double* const x = x_.data() + supernodes_.offset[index(supernodes_.first[index(f)])];
  std::fill(std::copy_n(x, front.width, own_.begin()), own_.begin() + front.strips * kernels_.strip,
            0.0);
  kernels_.forward_rows(triangle(front), rows(front), front.rows_strips, own_.data(),
                        below_.data());
  std::copy_n(own_.data(), front.width, x);
  for_rows(f, [&](std::int64_t i, std::int64_t below) { x_[index(i)] += below_[index(below)]; });
}

void SupernodalCholesky::backward(std::int32_t f) {
  const FrontLayout::Front& front = layout_.fronts[index(f)];
  double* const x = x_.data() + supernodes_.offset[index(supernodes_.first[index(f)])];
  std::fill(std::copy_n(x, front.width, own_.begin()), own_.begin() + front.strips * kernels_.strip,
            0.0);
  std::fill_n(below_.begin(), front.rows_strips * kernels_.strip, 0.0);
  for_rows(f, [&](std::int64_t i, std::int64_t below) { below_[index(below)] = x_[index(i)]; });
  kernels_.backward_rows(triangle(front), rows(front), front.rows_strips, own_.data(),
                         below_.data());
  std::copy_n(own_.data(), front.width, x);
}

}  // namespace raybundle::linalg
