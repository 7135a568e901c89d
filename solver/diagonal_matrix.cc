#include <raybundle/solver/diagonal_matrix.h>

#include <algorithm>
#include <array>

namespace raybundle {
namespace {

// Nine numbers in the order of a camera's parameters; fixed lenses use the first six.
std::array<double, 9> camera_weights(const Increments& inc) {
  const auto weight = [&](double increment) {
    const double ratio = inc.point / increment;
    return ratio * ratio;
  };
  const double rotation = weight(inc.rotation), translation = weight(inc.translation);
  return {rotation,    rotation,          rotation,       translation,   translation,
          translation, weight(inc.focal), weight(inc.k1), weight(inc.k2)};
}

}  // namespace

void fill_diagonal(DiagonalMatrix kind, const Increments& inc,
                   const linalg::NormalEquations& normal, std::vector<double>& d) {
  d.resize(normal.gradient.size());
  if (kind == DiagonalMatrix::diag_h) {
    normal.diagonal(min_diagonal, max_diagonal, d.data());
    return;
  }
  std::fill(d.begin(), d.end(), 1.0);
  if (kind == DiagonalMatrix::identity) return;
  const std::array<double, 9> weights = camera_weights(inc);
  const int size = normal.layout->hub_size;
  for (std::int64_t camera = 0; camera < normal.layout->hubs; ++camera) {
    std::copy_n(weights.begin(), size, d.begin() + camera * size);
  }
}

Increments increments(const Options& options) {
  Increments inc;
  inc.rotation = options.inc.rotation.value_or(inc.rotation);
  inc.translation = options.inc.translation.value_or(inc.translation);
  inc.focal = options.inc.focal.value_or(inc.focal);
  inc.k1 = options.inc.k1.value_or(inc.k1);
  inc.k2 = options.inc.k2.value_or(inc.k2);
  inc.point = options.inc.point.value_or(inc.point);
  return inc;
}

}  // namespace raybundle
