#pragma once

#include <raybundle/linalg/supernodes.h>

#include <vector>

namespace raybundle::linalg {

/// Where the numbers of a multifrontal factorisation [Liu92] stand, and who computes which: all
/// that can be said before there are any. The front of a supernode is a packed triangle L of its
/// columns, the rows R below, and C, what these leave for the parent. L and R stay as the factor; C
/// waits in an arena until the parent has taken it.
struct FrontLayout {
  struct Front {
    std::int64_t width = 0, height = 0;  ///< scalars
    std::int64_t columns = 0;            ///< width rounded up to whole steps
    std::int64_t strips = 0;             ///< of L
    std::int64_t rows_strips = 0;        ///< of R and C
    std::int64_t values = 0;             ///< L, and behind it R, in the factor
    std::int64_t pivots = 0;             ///< inverse diagonal and thresholds, likewise
    std::int64_t kept = 0;               ///< C, in the arena
    std::int64_t target = 0;             ///< of its rows, in FrontLayout::target
    int depth = 0;                       ///< parents above
    bool shared = true;                  ///< C is in the shared arena, else in that of a lane
  };
  /// A whole subtree, by one lane alone: supernodes [first, last].
  struct Subtree {
    std::int32_t first, last;
    double work;
  };

  std::vector<Front> fronts;
  std::vector<std::int32_t> child_begin, child;  ///< of supernode s: child[child_begin[s]] ...
  std::vector<std::int32_t> target;  ///< scalar rows of a front, counted in that of its parent
  std::vector<Subtree> subtrees;     ///< the most work first
  std::vector<std::int32_t> top;     ///< what is left, by all lanes together, in this order
  std::int64_t factor_size = 0, pivots_size = 0;  ///< numbers
  std::int64_t shared_size = 0, lane_size = 0;    ///< of the arenas
  std::int64_t most_strips = 0;                   ///< of a triangle

  /// For `lanes` threads, with so many rows in a strip and columns in a step.
  FrontLayout(const Supernodes& supernodes, std::int64_t strip, std::int64_t step, int lanes);

 private:
  void measure(const Supernodes& supernodes, std::int64_t strip, std::int64_t step);
  void find_targets(const Supernodes& supernodes);
  void share_out(const Supernodes& supernodes, int lanes);
  void place_kept(std::int64_t strip);
};

/// Numbers in a packed triangle of so many strips.
constexpr std::int64_t packed_size(std::int64_t strips, std::int64_t strip) {
  return strip * strip / 2 * strips * (strips + 1);
}

}  // namespace raybundle::linalg
