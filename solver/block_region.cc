#include <raybundle/solver/block_region.h>

#include <raybundle/models/statistics.h>

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

using linalg::index;

double inverse(const StepRequest& request, std::int64_t i) {
  return request.inverse_scaling == nullptr ? 1 : request.inverse_scaling[i];
}

}  // namespace

template <class Visit>
void BlockRegion::for_blocks(Visit&& visit) const {
  const int size = layout_.block_size(*side_);
  for (std::int64_t b = 0; b < layout_.block_count(*side_); ++b) {
    const std::int64_t first = layout_.offset(*side_) + b * size;
    visit(first, first + size);
  }
}

const double* BlockRegion::hold(const StepRequest& request) {
  const bool held = side_ && request.block_radius && std::isfinite(*request.block_radius);
  if (!held) return request.damping;
  damping_.assign(request.damping, request.damping + layout_.unknowns());
  const double* g = request.at.normal->gradient.data();
  for_blocks([&](std::int64_t first, std::int64_t last) {
    double squares = 0;
    for (std::int64_t i = first; i < last; ++i) {
      const double scaled = inverse(request, i) * g[i];
      squares += scaled * scaled;
    }
    const double lambda = std::sqrt(squares) / *request.block_radius;
    for (std::int64_t i = first; i < last; ++i) {
      damping_[index(i)] += lambda / (inverse(request, i) * inverse(request, i));
    }
  });
  return damping_.data();
}

void BlockRegion::measure(const StepRequest& request, const double* step, StepReport& report) {
  if (!side_ || !request.block_radius) return;
  lengths_.clear();
  for_blocks([&](std::int64_t first, std::int64_t last) {
    double squares = 0;
    for (std::int64_t i = first; i < last; ++i) {
      const double scaled = step[i] / inverse(request, i);
      squares += scaled * scaled;
    }
    if (squares > 0) lengths_.push_back(std::sqrt(squares));
  });
  if (lengths_.empty()) return;
  if (std::isfinite(*request.block_radius)) {
    report.block_length = *std::max_element(lengths_.begin(), lengths_.end());
    report.block_on_boundary = report.block_length > 0.5 * *request.block_radius;
  } else {
    report.block_length = 10 * upper_median(lengths_);
  }
}

}  // namespace raybundle
