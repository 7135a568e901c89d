#pragma once

#include <raybundle/models/random.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace raybundle::init {

struct RansacOptions {
  double confidence = 0.9999;  ///< that one sample had no outlier, if what it led to is right
  int min_iterations = 20;
  int max_iterations = 2000;
};

/// How well a model fits: squared errors, each cut at the square of the threshold, summed; and how
/// many are below it.
struct Fit {
  double cost = 0;
  std::int64_t inliers = 0;
};

/// The fit of `size` measurements with squared errors error(i).
template <class Error>
Fit fit_of(std::int64_t size, double threshold, Error&& error) {
  Fit result;
  const double most = threshold * threshold;
  for (std::int64_t i = 0; i < size; ++i) {
    const double squared = error(i);
    result.cost += squared < most ? squared : most;  // also of one that is no number
    result.inliers += squared < most ? 1 : 0;
  }
  return result;
}

/// Those that are below the threshold, ascending.
template <class Error>
std::vector<std::int32_t> inliers_of(std::int64_t size, double threshold, Error&& error) {
  std::vector<std::int32_t> result;
  for (std::int32_t i = 0; i < size; ++i) {
    if (error(i) < threshold * threshold) result.push_back(i);
  }
  return result;
}

template <class Model>
struct Consensus {
  Model model;
  Fit fit;
  int iterations = 0;
};

/// Samples until one without outliers was, as far as the best fit tells, among them
/// [FischlerBolles81], with costs that are cut [TorrZisserman00], and every new best improved on
/// its own inliers [Chum03]. The sequence of samples depends on `random` alone. An Estimator has
///   Model, sample_size, size()               measurements
///   for_models(sample, visit)                calls visit(model) for all that a sample allows
///   fit(model)
///   improved(model) -> optional<Model>       by all that fit it
/// Empty where there are fewer than sample_size + 1 measurements or no sample allowed a model.
template <class Estimator>
std::optional<Consensus<typename Estimator::Model>> ransac(const Estimator& estimator,
                                                           const RansacOptions& options,
                                                           Random& random) {
  constexpr std::size_t k = Estimator::sample_size;
  const std::int64_t size = estimator.size();
  std::optional<Consensus<typename Estimator::Model>> best;
  if (size <= static_cast<std::int64_t>(k)) return best;

  const auto enough = [&](const Fit& fit) {
    const double good = std::pow(static_cast<double>(fit.inliers) / static_cast<double>(size),
                                 static_cast<double>(k));
    if (good >= 1) return 1.0;
    return std::log(1 - options.confidence) / std::log1p(-good);
  };
  std::array<std::int64_t, k> sample;
  double needed = options.max_iterations;
  int iteration = 0;
  for (; iteration < options.max_iterations; ++iteration) {
    if (iteration >= options.min_iterations && iteration >= needed) break;
    for (std::size_t i = 0; i < k; ++i) {
      do {
        sample[i] = random.below(size);
      } while (std::find(sample.begin(), sample.begin() + i, sample[i]) != sample.begin() + i);
    }
    bool better = false;
    const auto consider = [&](const typename Estimator::Model& model) {
      const Fit fit = estimator.fit(model);
      if (best && fit.cost >= best->fit.cost) return;
      best = {model, fit, 0};
      better = true;
    };
    estimator.for_models(sample, consider);
    if (!better) continue;
    if (const auto improved = estimator.improved(best->model)) consider(*improved);
    needed = enough(best->fit);
  }
  if (best) best->iterations = iteration;
  return best;
}

}  // namespace raybundle::init
