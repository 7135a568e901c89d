#include <raybundle/solver/diagonal_matrix.h>

#include <algorithm>
#include <array>
#include <cstdint>

namespace raybundle {
namespace {

double squared_ratio(double a, double b) { return (a / b) * (a / b); }

// Nine numbers in the order of a camera's parameters; fixed lenses use the first six.
std::array<double, 9> camera_weights(const Increments& inc, double unit) {
  const double rotation = squared_ratio(unit, inc.rotation);
  const double translation = squared_ratio(unit, inc.translation);
  return {rotation,
          rotation,
          rotation,
          translation,
          translation,
          translation,
          squared_ratio(unit, inc.focal),
          squared_ratio(unit, inc.k1),
          squared_ratio(unit, inc.k2)};
}

void fill_blocks(const linalg::BlockLayout& layout, linalg::Side side, const double* block,
                 double* d) {
  const int size = layout.block_size(side);
  d += layout.offset(side);
  for (std::int64_t i = 0; i < layout.block_count(side); ++i, d += size) {
    std::copy_n(block, size, d);
  }
}

void hold_points(const linalg::BlockLayout& layout, double* d, linalg::ThreadPool& pool) {
  const int size = layout.leaf_size;
  d += layout.offset(linalg::Side::leaves);
  linalg::parallel_for(pool, layout.leaves, 4096, [&](std::int64_t first, std::int64_t last) {
    for (double* point = d + first * size; first < last; ++first, point += size) {
      const double least = held_share * *std::max_element(point, point + size);
      for (int i = 0; i < size; ++i) point[i] = std::max(point[i], least);
    }
  });
}

}  // namespace

void fill_diagonal(DiagonalMatrix kind, const Increments& inc, PointModel points,
                   const linalg::NormalEquations& normal, linalg::LargeVector<double>& d,
                   linalg::ThreadPool& pool) {
  d.resize(normal.gradient.size());
  if (is_of_h(kind)) {
    normal.diagonal(min_diagonal, max_diagonal, d.data(), pool);
    if (kind == DiagonalMatrix::held_h) hold_points(*normal.layout, d.data(), pool);
    return;
  }
  std::fill(d.begin(), d.end(), 1.0);
  if (kind == DiagonalMatrix::identity) return;
  const bool anchored = is_anchored(points);
  const double unit = anchored ? inc.direction : inc.point;
  const std::array<double, 9> camera = camera_weights(inc, unit);
  fill_blocks(*normal.layout, linalg::Side::hubs, camera.data(), d.data());
  if (!anchored) return;
  const std::array<double, 3> point = {squared_ratio(unit, inc.parallax), 1, 1};
  fill_blocks(*normal.layout, linalg::Side::leaves, point.data(), d.data());
}

Increments increments(const Options& options) {
  Increments inc = shipped_increments(options.points);
  inc.rotation = options.inc.rotation.value_or(inc.rotation);
  inc.translation = options.inc.translation.value_or(inc.translation);
  inc.focal = options.inc.focal.value_or(inc.focal);
  inc.k1 = options.inc.k1.value_or(inc.k1);
  inc.k2 = options.inc.k2.value_or(inc.k2);
  inc.point = options.inc.point.value_or(inc.point);
  inc.parallax = options.inc.parallax.value_or(inc.parallax);
  inc.direction = options.inc.direction.value_or(inc.direction);
  return inc;
}

}  // namespace raybundle
