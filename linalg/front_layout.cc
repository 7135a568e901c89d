#include <raybundle/linalg/front_layout.h>

#include <raybundle/linalg/kernels/dense_kernels.h>

#include <algorithm>
#include <array>

namespace raybundle::linalg {
namespace {

// An arena with two ends: what waits for fronts of even depth stands at one, of odd depth at the
// other. So a front's C is written while those of its children are read, and both ends are stacks.
class Arena {
 public:
  std::int64_t push(int depth, std::int64_t size) {
    std::int64_t& end = used_[index(depth % 2)];
    const std::int64_t begin = end;
    end += size;
    size_ = std::max(size_, used_[0] + used_[1]);
    return depth % 2 == 0 ? begin : -end;  // from the start, or back from the end
  }
  void pop(int depth, std::int64_t size) { used_[index(depth % 2)] -= size; }
  void forget() { used_ = {}; }
  std::int64_t size() const { return size_; }

 private:
  std::array<std::int64_t, 2> used_ = {};
  std::int64_t size_ = 0;
};

}  // namespace

FrontLayout::FrontLayout(const Supernodes& supernodes, std::int64_t strip, std::int64_t step,
                         int lanes)
    : fronts(index(supernodes.count())) {
  measure(supernodes, strip, step);
  find_targets(supernodes);
  share_out(supernodes, lanes);
  place_kept(strip);
}

void FrontLayout::measure(const Supernodes& supernodes, std::int64_t strip, std::int64_t step) {
  const std::int32_t count = supernodes.count();
  child_begin.assign(index(count + 1), 0);
  std::int64_t rows = 0;
  for (std::int32_t s = count - 1; s >= 0; --s) {
    Front& front = fronts[index(s)];
    front.width = supernodes.width(s);
    front.height = supernodes.height(s);
    front.columns = ceil_div(front.width, step) * step;
    front.strips = ceil_div(front.width, strip);
    front.rows_strips = ceil_div(front.height, strip);
    front.values = factor_size;
    front.pivots = pivots_size;
    front.target = rows;
    factor_size += packed_size(front.strips, strip) + front.rows_strips * strip * front.columns;
    pivots_size += 2 * front.strips * strip;
    rows += front.height;
    most_strips = std::max(most_strips, front.strips);
    const std::int32_t parent = supernodes.parent[index(s)];
    if (parent < 0) continue;
    front.depth = fronts[index(parent)].depth + 1;
    ++child_begin[index(parent + 1)];
  }
  for (std::int32_t s = 0; s < count; ++s) child_begin[index(s + 1)] += child_begin[index(s)];
  child.resize(index(child_begin.back()));
  std::vector<std::int32_t> next = child_begin;
  for (std::int32_t s = 0; s < count; ++s) {
    const std::int32_t parent = supernodes.parent[index(s)];
    if (parent >= 0) child[index(next[index(parent)]++)] = s;
  }
  target.resize(index(rows));
}

void FrontLayout::find_targets(const Supernodes& supernodes) {
  const std::vector<std::int64_t>& offset = supernodes.offset;
  std::vector<std::int32_t> local(supernodes.order.size());  // of a place, in the parent's front
  for (std::int32_t s = 0; s < supernodes.count(); ++s) {
    std::int64_t next = 0;
    const auto add = [&](std::int32_t k) {
      local[index(k)] = static_cast<std::int32_t>(next);
      next += offset[index(k + 1)] - offset[index(k)];
    };
    for (std::int32_t k = supernodes.first[index(s)]; k < supernodes.first[index(s + 1)]; ++k) {
      add(k);
    }
    for (std::int64_t p = supernodes.row_begin[index(s)]; p < supernodes.row_begin[index(s + 1)];
         ++p) {
      add(supernodes.row[index(p)]);
    }
    for (std::int32_t c = child_begin[index(s)]; c < child_begin[index(s + 1)]; ++c) {
      const std::int32_t from = child[index(c)];
      auto to = target.begin() + fronts[index(from)].target;
      for (std::int64_t p = supernodes.row_begin[index(from)];
           p < supernodes.row_begin[index(from + 1)]; ++p) {
        const std::int32_t k = supernodes.row[index(p)];
        const std::int64_t size = offset[index(k + 1)] - offset[index(k)];
        for (std::int64_t i = 0; i < size; ++i) {
          *to++ = local[index(k)] + static_cast<std::int32_t>(i);
        }
      }
    }
  }
}

// Subtrees small enough that several go to each lane; what is above them has large fronts, whose
// own parts are shared out. Alone, everything is top.
void FrontLayout::share_out(const Supernodes& supernodes, int lanes) {
  const std::int32_t count = supernodes.count();
  std::vector<double> work(index(count));
  std::vector<std::int32_t> first(index(count));
  double total = 0;
  for (std::int32_t s = 0; s < count; ++s) {
    const double own = front_work(static_cast<double>(fronts[index(s)].width),
                                  static_cast<double>(fronts[index(s)].height));
    total += own;
    work[index(s)] = own;
    first[index(s)] = s;
    for (std::int32_t c = child_begin[index(s)]; c < child_begin[index(s + 1)]; ++c) {
      const std::size_t below = index(child[index(c)]);
      work[index(s)] += work[below];
      first[index(s)] = std::min(first[index(s)], first[below]);
    }
  }
  constexpr int subtrees_of_lane = 6;
  const double most = lanes > 1 ? total / (subtrees_of_lane * lanes) : -1;
  for (std::int32_t s = 0; s < count; ++s) {
    if (work[index(s)] > most) {
      top.push_back(s);
      continue;
    }
    const std::int32_t parent = supernodes.parent[index(s)];
    const bool root = parent < 0 || work[index(parent)] > most;
    fronts[index(s)].shared = root;
    if (root) subtrees.push_back({first[index(s)], s, work[index(s)]});
  }
  std::stable_sort(subtrees.begin(), subtrees.end(),
                   [](const Subtree& a, const Subtree& b) { return a.work > b.work; });
}

void FrontLayout::place_kept(std::int64_t strip) {
  const auto size = [&](std::int32_t s) {
    return packed_size(fronts[index(s)].rows_strips, strip);
  };
  const auto pop_children = [&](std::int32_t s, Arena& arena) {
    for (std::int32_t c = child_begin[index(s)]; c < child_begin[index(s + 1)]; ++c) {
      arena.pop(fronts[index(child[index(c)])].depth, size(child[index(c)]));
    }
  };
  Arena lane;
  std::int64_t roots = 0;
  for (const Subtree& subtree : subtrees) {
    for (std::int32_t s = subtree.first; s < subtree.last; ++s) {
      fronts[index(s)].kept = lane.push(fronts[index(s)].depth, size(s));
      pop_children(s, lane);
    }
    lane.forget();
    fronts[index(subtree.last)].kept = roots;
    roots += size(subtree.last);
  }
  lane_size = lane.size();

  // Roots of subtrees stand before the arena of what is above them.
  Arena shared;
  for (const std::int32_t s : top) {
    fronts[index(s)].kept = shared.push(fronts[index(s)].depth, size(s));
    for (std::int32_t c = child_begin[index(s)]; c < child_begin[index(s + 1)]; ++c) {
      const std::int32_t below = child[index(c)];
      const bool is_top = std::binary_search(top.begin(), top.end(), below);
      if (is_top) shared.pop(fronts[index(below)].depth, size(below));
    }
  }
  shared_size = roots + shared.size();
  for (const std::int32_t s : top) {
    if (fronts[index(s)].kept >= 0) fronts[index(s)].kept += roots;
  }
}

}  // namespace raybundle::linalg
