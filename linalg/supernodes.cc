// The elimination tree, node by node: the structure of a column is that of A below it and of its
// children in the tree, and its parent is the first row of it [Liu92]. Merging goes up the tree.

#include <raybundle/linalg/supernodes.h>

#include <raybundle/linalg/kernels/dense_kernels.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace raybundle::linalg {
namespace {

constexpr std::int32_t none = -1;

double rounded_up(double value, double step) { return std::ceil(value / step) * step; }

// A group of places while the tree is built, by the last place it has.
struct Node {
  std::vector<std::int32_t> places;
  std::vector<std::int32_t> rows;  // places below
  std::vector<std::int32_t> children;
  double width = 0, height = 0;  // scalars
  double kept = 0, peak = 0;     // numbers that wait for the parent, and most at a time
};

class Tree {
 public:
  Tree(const SymmetricPattern& pattern, const std::vector<std::int64_t>& permutation)
      : pattern_(pattern), node_(index(pattern.blocks())), size_(index(pattern.blocks())) {
    std::vector<std::int32_t> place(size_.size());
    for (std::size_t k = 0; k < size_.size(); ++k) {
      place[index(permutation[k])] = static_cast<std::int32_t>(k);
      size_[k] = static_cast<double>(pattern.block_size(permutation[k]));
    }
    for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
      for (std::int64_t p = pattern.row_begin[index(a)]; p < pattern.row_begin[index(a + 1)]; ++p) {
        const auto [i, j] = std::minmax(place[index(a)], place[index(pattern.column[index(p)])]);
        if (i != j) node_[index(i)].rows.push_back(j);
      }
    }
    grow();
  }

  Supernodes number(const std::vector<std::int64_t>& permutation) const;

 private:
  void grow();
  void merge_children(std::int32_t j);
  void sort_children(Node& node);
  std::vector<std::int32_t> post_order() const;

  const SymmetricPattern& pattern_;
  std::vector<Node> node_;
  std::vector<double> size_;  // of the block at a place
  std::vector<std::int32_t> roots_;
};

void Tree::grow() {
  std::vector<std::int32_t> seen(node_.size(), none);
  for (std::int32_t j = 0; index(j) < node_.size(); ++j) {
    Node& node = node_[index(j)];
    seen[index(j)] = j;
    for (const std::int32_t i : node.rows) seen[index(i)] = j;
    for (const std::int32_t child : node.children) {
      for (const std::int32_t i : node_[index(child)].rows) {
        if (std::exchange(seen[index(i)], j) != j) node.rows.push_back(i);
      }
    }
    node.places = {j};
    node.width = size_[index(j)];
    for (const std::int32_t i : node.rows) node.height += size_[index(i)];
    merge_children(j);
    const auto parent = std::min_element(node.rows.begin(), node.rows.end());
    (parent == node.rows.end() ? roots_ : node_[index(*parent)].children).push_back(j);
  }
}

// The child whose structure is closest comes first.
void Tree::merge_children(std::int32_t j) {
  Node& node = node_[index(j)];
  std::vector<std::int32_t> children = std::exchange(node.children, {});
  std::stable_sort(children.begin(), children.end(), [&](std::int32_t a, std::int32_t b) {
    return node_[index(a)].height > node_[index(b)].height;
  });
  for (const std::int32_t c : children) {
    Node& child = node_[index(c)];
    const double apart =
        front_work(node.width, node.height) + front_work(child.width, child.height);
    if (front_work(node.width + child.width, node.height) > apart) {
      node.children.push_back(c);
      continue;
    }
    node.width += child.width;
    child.places.insert(child.places.end(), node.places.begin(), node.places.end());
    node.places.swap(child.places);
    node.children.insert(node.children.end(), child.children.begin(), child.children.end());
    child = {};
  }
  sort_children(node);
}

// By what is gained in storage when one comes first [Liu92].
void Tree::sort_children(Node& node) {
  const auto gain = [&](std::int32_t c) { return node_[index(c)].peak - node_[index(c)].kept; };
  std::stable_sort(node.children.begin(), node.children.end(),
                   [&](std::int32_t a, std::int32_t b) { return gain(a) > gain(b); });
  node.kept = node.height * node.height / 2;
  double waiting = 0;
  for (const std::int32_t c : node.children) {
    node.peak = std::max(node.peak, waiting + node_[index(c)].peak);
    waiting += node_[index(c)].kept;
  }
  node.peak = std::max(node.peak, waiting + node.kept);
}

std::vector<std::int32_t> Tree::post_order() const {
  std::vector<std::int32_t> result;
  std::vector<std::int32_t> open(roots_.begin(), roots_.end());  // parents before children, ...
  while (!open.empty()) {
    const std::int32_t j = open.back();
    open.pop_back();
    result.push_back(j);
    open.insert(open.end(), node_[index(j)].children.begin(), node_[index(j)].children.end());
  }
  std::reverse(result.begin(), result.end());  // ... so backwards children in their order
  return result;
}

Supernodes Tree::number(const std::vector<std::int64_t>& permutation) const {
  const std::vector<std::int32_t> nodes = post_order();
  Supernodes result;
  std::vector<std::int32_t> supernode_of(node_.size()), moved(node_.size());
  result.first = {0};
  for (const std::int32_t j : nodes) {
    supernode_of[index(j)] = result.count();
    for (const std::int32_t old : node_[index(j)].places) {
      moved[index(old)] = static_cast<std::int32_t>(result.order.size());
      result.order.push_back(static_cast<std::int32_t>(permutation[index(old)]));
    }
    result.first.push_back(static_cast<std::int32_t>(result.order.size()));
    result.parent.push_back(none);
  }
  result.place.resize(result.order.size());
  result.offset = {0};
  for (std::size_t k = 0; k < result.order.size(); ++k) {
    result.place[index(result.order[k])] = static_cast<std::int32_t>(k);
    result.offset.push_back(result.offset.back() + pattern_.block_size(result.order[k]));
  }
  result.row_begin = {0};
  for (const std::int32_t j : nodes) {
    const Node& node = node_[index(j)];
    for (const std::int32_t c : node.children) {
      result.parent[index(supernode_of[index(c)])] = supernode_of[index(j)];
    }
    for (const std::int32_t i : node.rows) result.row.push_back(moved[index(i)]);
    std::sort(result.row.begin() + result.row_begin.back(), result.row.end());
    result.row_begin.push_back(static_cast<std::int64_t>(result.row.size()));
  }
  return result;
}

}  // namespace

std::int64_t Supernodes::width(std::int32_t s) const {
  return offset[index(first[index(s + 1)])] - offset[index(first[index(s)])];
}

std::int64_t Supernodes::height(std::int32_t s) const {
  std::int64_t sum = 0;
  for (std::int64_t p = row_begin[index(s)]; p < row_begin[index(s + 1)]; ++p) {
    sum += offset[index(row[index(p)] + 1)] - offset[index(row[index(p)])];
  }
  return sum;
}

Supernodes find_supernodes(const SymmetricPattern& pattern,
                           const std::vector<std::int64_t>& permutation) {
  return Tree(pattern, permutation).number(permutation);
}

// Beside the products: each number is cleared and written once, what is kept for the parent is
// added to it number by number, and a front has some work of its own.
double front_work(double width, double height) {
  constexpr auto strip = static_cast<double>(widest_strip);
  constexpr auto step = static_cast<double>(widest_step);
  constexpr double per_number = 8, per_kept_number = 16, per_front = 20000;
  const double w = rounded_up(width, step), h = rounded_up(height, strip);
  return w * w * w / 6 + w * w * h / 2 + w * h * h / 2 + per_number * w * (w / 2 + h) +
         per_kept_number * h * h / 2 + per_front;
}

double factor_work(const Supernodes& supernodes) {
  double sum = 0;
  for (std::int32_t s = 0; s < supernodes.count(); ++s) {
    sum += front_work(static_cast<double>(supernodes.width(s)),
                      static_cast<double>(supernodes.height(s)));
  }
  return sum;
}

}  // namespace raybundle::linalg
