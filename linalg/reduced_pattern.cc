#include <raybundle/linalg/reduced_pattern.h>

#include <raybundle/linalg/memory.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace raybundle::linalg {
namespace {

/// Finds the kept blocks that share an eliminated block with a given one.
class Neighbours {
 public:
  Neighbours(const BlockLayout& layout, Side eliminated)
      : kept_(layout.incidence(opposite(eliminated))),
        eliminated_(layout.incidence(eliminated)),
        position_(positions(eliminated_)) {}

  /// Calls visit(b) once for every such b > a; seen[b] is a mark that must be different from a
  /// before.
  template <class Visit>
  void visit_after(std::int64_t a, std::vector<std::int32_t>& seen, Visit&& visit) const {
    const auto mark = static_cast<std::int32_t>(a);
    seen[index(a)] = mark;
    for (std::int64_t p = kept_.begin[index(a)]; p < kept_.begin[index(a + 1)]; ++p) {
      const std::int64_t c = kept_.list.empty() ? p : kept_.list[index(p)];
      const std::int64_t start = position_.empty() ? c : position_[index(c)];
      const std::int64_t end = eliminated_.begin[index(eliminated_.block[index(c)]) + 1];
      for (std::int64_t q = start; q < end; ++q) {
        const std::int64_t other = eliminated_.list.empty() ? q : eliminated_.list[index(q)];
        const std::int32_t b = kept_.block[index(other)];
        if (std::exchange(seen[index(b)], mark) == mark) continue;
        visit(b);
      }
    }
  }

 private:
  const Incidence& kept_;
  const Incidence& eliminated_;
  LargeVector<std::int32_t> position_;
};

// A reduced matrix can have the square of the kept blocks: what cannot be held is refused here and
// not half-way. The least that any use of it takes is the matrix itself; what a factorisation has
// beside it depends on its kind.
void require_pattern_memory(const BlockLayout& layout, Side eliminated, ThreadPool& pool) {
  const Side kept = opposite(eliminated);
  const double size = layout.block_size(kept);
  require_memory(most_reduced_blocks(layout, eliminated, pool) * (8 * size * size + 12),
                 "the reduced matrix of " + std::to_string(layout.block_count(kept)) + " blocks");
}

// How many neighbours after themselves every `stride`-th kept block has, from the middle of each.
double later_neighbours(const BlockLayout& layout, Side eliminated, std::int64_t stride,
                        ThreadPool& pool) {
  const std::int64_t count = layout.block_count(opposite(eliminated));
  const std::int64_t sampled = (count + stride - 1 - stride / 2) / stride;
  const Neighbours neighbours(layout, eliminated);
  return parallel_sum(pool, sampled, 16, [&](std::int64_t first, std::int64_t last) {
    std::vector<std::int32_t> seen(index(count), -1);
    std::int64_t found = 0;
    for (std::int64_t s = first; s < last; ++s) {
      neighbours.visit_after(s * stride + stride / 2, seen, [&](std::int32_t) { ++found; });
    }
    return static_cast<double>(found);
  });
}

}  // namespace

std::int64_t count_reduced_blocks(const BlockLayout& layout, Side eliminated, ThreadPool& pool) {
  const std::int64_t count = layout.block_count(opposite(eliminated));
  return count + static_cast<std::int64_t>(later_neighbours(layout, eliminated, 1, pool));
}

double sampled_reduced_blocks(const BlockLayout& layout, Side eliminated, ThreadPool& pool) {
  constexpr std::int64_t stride = 16;
  const auto count = static_cast<double>(layout.block_count(opposite(eliminated)));
  return count + double{stride} * later_neighbours(layout, eliminated, stride, pool);
}

double most_reduced_blocks(const BlockLayout& layout, Side eliminated_side, ThreadPool& pool) {
  constexpr double few = 1e7;
  const Incidence& eliminated = layout.incidence(eliminated_side);
  double blocks = 0;
  for (std::int64_t e = 0; e < layout.block_count(eliminated_side); ++e) {
    const auto degree =
        static_cast<double>(eliminated.begin[index(e + 1)] - eliminated.begin[index(e)]);
    blocks += degree * (degree + 1) / 2;
  }
  const auto all = static_cast<double>(layout.block_count(opposite(eliminated_side)));
  blocks = std::min(blocks, all * (all + 1) / 2);
  if (blocks <= few) return blocks;
  return static_cast<double>(count_reduced_blocks(layout, eliminated_side, pool));
}

SymmetricPattern reduced_pattern(const BlockLayout& layout, Side eliminated, ThreadPool& pool) {
  require_pattern_memory(layout, eliminated, pool);
  const Side kept = opposite(eliminated);
  const std::int64_t count = layout.block_count(kept);
  SymmetricPattern pattern;
  for (std::int64_t a = 0; a <= count; ++a) {
    pattern.offset.push_back(a * layout.block_size(kept));
  }
  pattern.row_begin.assign(index(count + 1), 0);
  const Neighbours neighbours(layout, eliminated);
  const Chunks pieces = chunks(count, 16);
  std::vector<std::vector<std::int32_t>> columns(index(pieces.pieces));
  pool.run(pieces.pieces, [&](std::int64_t piece) {
    std::vector<std::int32_t>& column = columns[index(piece)];
    std::vector<std::int32_t> seen(index(count), -1);
    for (std::int64_t a = pieces.begin(piece); a < pieces.end(piece); ++a) {
      const auto begin = static_cast<std::int64_t>(column.size());
      column.push_back(static_cast<std::int32_t>(a));
      neighbours.visit_after(a, seen, [&](std::int32_t b) { column.push_back(b); });
      std::sort(column.begin() + begin, column.end());
      pattern.row_begin[index(a + 1)] = static_cast<std::int64_t>(column.size()) - begin;
    }
  });
  for (std::int64_t a = 0; a < count; ++a) {
    pattern.row_begin[index(a + 1)] += pattern.row_begin[index(a)];
  }
  pattern.column.reserve(index(pattern.row_begin.back()));
  for (std::vector<std::int32_t>& column : columns) {
    pattern.column.insert(pattern.column.end(), column.begin(), column.end());
    column = {};
  }
  return pattern;
}

}  // namespace raybundle::linalg
