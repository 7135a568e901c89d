#include <raybundle/linalg/reduced_pattern.h>

#include <raybundle/linalg/memory.h>

#include <algorithm>
#include <string>
#include <vector>

namespace raybundle::linalg {
namespace {

/// Finds the kept blocks that share an eliminated block with a given one.
class Neighbours {
 public:
  Neighbours(const BlockLayout& layout, Side eliminated)
      : kept_(layout.incidence(opposite(eliminated))),
        eliminated_(layout.incidence(eliminated)),
        position_(positions(eliminated_)),
        seen_(index(layout.block_count(opposite(eliminated))), -1) {}

  /// Calls visit(b) once for every such b > a; not twice for the same a.
  template <class Visit>
  void visit_after(std::int64_t a, Visit&& visit) {
    seen_[index(a)] = a;
    for (std::int64_t p = kept_.begin[index(a)]; p < kept_.begin[index(a + 1)]; ++p) {
      const std::int64_t c = kept_.list.empty() ? p : kept_.list[index(p)];
      const std::int64_t start = position_.empty() ? c : position_[index(c)];
      const std::int64_t end = eliminated_.begin[index(eliminated_.block[index(c)]) + 1];
      for (std::int64_t q = start; q < end; ++q) {
        const std::int64_t other = eliminated_.list.empty() ? q : eliminated_.list[index(q)];
        const std::int32_t b = kept_.block[index(other)];
        if (seen_[index(b)] == a) continue;
        seen_[index(b)] = a;
        visit(b);
      }
    }
  }

 private:
  const Incidence& kept_;
  const Incidence& eliminated_;
  LargeVector<std::int32_t> position_;
  std::vector<std::int64_t> seen_;
};

// A reduced matrix can have the square of the kept blocks. Where it may be large its blocks are
// counted before any is stored: what cannot be held is refused here and not half-way.
void require_pattern_memory(const BlockLayout& layout, Side eliminated_side) {
  const Side kept_side = opposite(eliminated_side);
  const Incidence& eliminated = layout.incidence(eliminated_side);
  const std::int64_t count = layout.block_count(kept_side);
  double blocks = 0;
  for (std::int64_t e = 0; e < layout.block_count(eliminated_side); ++e) {
    const auto degree =
        static_cast<double>(eliminated.begin[index(e + 1)] - eliminated.begin[index(e)]);
    blocks += degree * (degree + 1) / 2;
  }
  constexpr double few = 1e7;
  if (blocks > few) {
    blocks = static_cast<double>(count);
    Neighbours neighbours(layout, eliminated_side);
    for (std::int64_t a = 0; a < count; ++a) {
      neighbours.visit_after(a, [&](std::int32_t) { ++blocks; });
    }
  }
  // The least that any factorisation takes: a full matrix in dense storage, with its workspace, has
  // 24 bytes per entry of the triangle (dense_cholesky.h); sparse storage has more.
  const double size = layout.block_size(kept_side);
  require_memory(blocks * (24 * size * size + 12),
                 "the reduced matrix of " + std::to_string(count) + " blocks");
}

}  // namespace

SymmetricPattern reduced_pattern(const BlockLayout& layout, Side eliminated) {
  require_pattern_memory(layout, eliminated);
  const Side kept = opposite(eliminated);
  const std::int64_t count = layout.block_count(kept);
  SymmetricPattern pattern;
  for (std::int64_t a = 0; a <= count; ++a) {
    pattern.offset.push_back(a * layout.block_size(kept));
  }
  Neighbours neighbours(layout, eliminated);
  pattern.row_begin.push_back(0);
  for (std::int64_t a = 0; a < count; ++a) {
    pattern.column.push_back(static_cast<std::int32_t>(a));
    neighbours.visit_after(a, [&](std::int32_t b) { pattern.column.push_back(b); });
    std::sort(pattern.column.begin() + pattern.row_begin.back(), pattern.column.end());
    pattern.row_begin.push_back(static_cast<std::int64_t>(pattern.column.size()));
  }
  return pattern;
}

}  // namespace raybundle::linalg
