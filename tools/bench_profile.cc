#include <raybundle/tools/bench_profile.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace raybundle::tools {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double clock_resolution = 1e-9;  // seconds; less is not told apart from it

/// The ratios of one solver on the problems it solves, ascending.
std::vector<double> ratios(const std::vector<std::vector<double>>& seconds, std::size_t solver) {
  std::vector<double> all;
  for (const std::vector<double>& problem : seconds) {
    if (!(problem[solver] < infinity)) continue;
    double best = infinity;
    for (const double each : problem) {
      if (each < best) best = each;
    }
    all.push_back(std::max(problem[solver], clock_resolution) / std::max(best, clock_resolution));
  }
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace

double target_cost(double start, double best, double tau) { return best + tau * (start - best); }

double seconds_to(const std::vector<CostAt>& trace, double target) {
  for (const CostAt& state : trace) {
    if (state.cost <= target) return state.seconds;
  }
  return infinity;
}

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  for (double& value : values) {
    if (std::isnan(value)) value = infinity;
  }
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  if (values.size() % 2 == 1) return values[middle];
  return 0.5 * (values[middle - 1] + values[middle]);
}

std::vector<Profile> profiles(const std::vector<std::vector<double>>& seconds) {
  std::vector<Profile> all(seconds.empty() ? 0 : seconds.front().size());
  const auto problems = static_cast<double>(seconds.size());
  for (std::size_t solver = 0; solver < all.size(); ++solver) {
    Profile& profile = all[solver];
    profile = {{1}, {0}};
    double solved = 0;
    for (const double ratio : ratios(seconds, solver)) {
      if (ratio > profile.ratio.back()) {
        profile.ratio.push_back(ratio);
        profile.share.push_back(0);
      }
      profile.share.back() = ++solved / problems;
    }
  }
  return all;
}

double share_at(const Profile& profile, double ratio) {
  const auto after = std::upper_bound(profile.ratio.begin(), profile.ratio.end(), ratio);
  if (after == profile.ratio.begin()) return 0;
  return profile.share[static_cast<std::size_t>(after - profile.ratio.begin()) - 1];
}

}  // namespace raybundle::tools
