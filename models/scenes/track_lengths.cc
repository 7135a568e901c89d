#include <raybundle/models/scenes/track_lengths.h>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace raybundle::scenes {
namespace {

constexpr std::int64_t shortest = 2;

/// theta^L / L^2 for L from `shortest` to `longest`.
std::vector<double> weights(double theta, std::int64_t longest) {
  std::vector<double> result;
  double power = 1;
  for (std::int64_t length = shortest; length <= longest; ++length, power *= theta) {
    const double l = static_cast<double>(length);
    result.push_back(power / (l * l));
  }
  return result;
}

double mean_length(const std::vector<double>& weight) {
  double sum = 0, moment = 0, length = shortest;
  for (const double w : weight) {
    sum += w;
    moment += length * w;
    length += 1;
  }
  return moment / sum;
}

/// Quantiles of the distribution, ascending: as even as a sample can be.
std::vector<std::int32_t> quantiles(const std::vector<double>& weight, std::int64_t count) {
  double total = 0;
  for (const double w : weight) total += w;
  std::vector<std::int32_t> lengths;
  lengths.reserve(static_cast<std::size_t>(count));
  std::size_t k = 0;
  double reached = weight[0];
  for (std::int64_t i = 0; i < count; ++i) {
    const double level = (static_cast<double>(i) + 0.5) / static_cast<double>(count) * total;
    while (reached < level && k + 1 < weight.size()) reached += weight[++k];
    lengths.push_back(static_cast<std::int32_t>(shortest + static_cast<std::int64_t>(k)));
  }
  return lengths;
}

/// One more or less here and there until the sum is right, or no length can change.
void adjust(std::vector<std::int32_t>& lengths, std::int64_t observations, std::int64_t longest) {
  std::int64_t missing = observations;
  for (const std::int32_t length : lengths) missing -= length;
  bool changed = true;
  while (missing != 0 && changed) {
    changed = false;
    for (auto length = lengths.rbegin(); length != lengths.rend() && missing != 0; ++length) {
      const std::int32_t step = missing > 0 ? 1 : -1;
      if (*length + step < shortest || *length + step > longest) continue;
      *length += step;
      missing -= step;
      changed = true;
    }
  }
}

}  // namespace

std::vector<std::int32_t> draw_track_lengths(std::int64_t points, std::int64_t observations,
                                             std::int64_t longest, Random& random) {
  const double mean = static_cast<double>(observations) / static_cast<double>(points);
  double low = 0, high = 1 + 40 / static_cast<double>(longest);  // its power stays in range
  for (int k = 0; k < 60; ++k) {
    const double theta = 0.5 * (low + high);
    (mean_length(weights(theta, longest)) < mean ? low : high) = theta;
  }
  std::vector<std::int32_t> lengths = quantiles(weights(0.5 * (low + high), longest), points);
  adjust(lengths, observations, longest);
  for (std::size_t i = lengths.size(); i > 1; --i) {
    std::swap(lengths[i - 1],
              lengths[static_cast<std::size_t>(random.below(static_cast<std::int64_t>(i)))]);
  }
  return lengths;
}

TrackPlan::TrackPlan(std::int64_t points, std::int64_t observations, std::int64_t longest,
                     Random& random) {
  if (observations > 0) {
    lengths_ = draw_track_lengths(points, observations, std::max(shortest, longest), random);
  }
}

std::int64_t TrackPlan::wanted(std::int64_t i) const {
  const std::int64_t length = lengths_[static_cast<std::size_t>(i)];
  return length + std::min(missing_, length);
}

std::int64_t TrackPlan::settle(std::int64_t i, std::int64_t available, Random& random) {
  const auto points = static_cast<std::int64_t>(lengths_.size());
  std::int32_t& length = lengths_[static_cast<std::size_t>(i)];
  // A later point may be seen by more; the last tenth takes what comes, or too much would be left.
  const std::int64_t later = points - points / 10 - i - 1;
  for (int attempt = 0; attempt < 20 && length > available && later > 0; ++attempt) {
    std::int32_t& other = lengths_[static_cast<std::size_t>(i + 1 + random.below(later))];
    if (other <= available) std::swap(length, other);
  }
  const std::int64_t result = std::min(wanted(i), available);
  missing_ += length - result;
  return result;
}

}  // namespace raybundle::scenes
