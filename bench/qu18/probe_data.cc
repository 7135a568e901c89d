#include <raybundle/bench/qu18/probe.h>

#include <algorithm>
#include <numeric>

#include <raybundle/models/alignment.h>
#include <raybundle/models/random.h>

namespace raybundle::bench {
namespace {

using linalg::index;

/// New index of each of `kept`, -1 of the others.
std::vector<std::int32_t> renumbered(const std::vector<bool>& kept) {
  std::vector<std::int32_t> number(kept.size(), -1);
  std::int32_t next = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (kept[i]) number[i] = next++;
  }
  return number;
}

std::vector<double> blocks_of(const std::vector<double>& values, const std::vector<bool>& kept,
                              std::size_t size) {
  std::vector<double> result;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (!kept[i]) continue;
    for (std::size_t k = 0; k < size; ++k) result.push_back(values[i * size + k]);
  }
  return result;
}

std::vector<bool> chosen_frames(std::int64_t count, std::int64_t frames, std::uint64_t seed) {
  std::vector<std::size_t> order(index(count));
  std::iota(order.begin(), order.end(), std::size_t{0});
  Random random(seed);
  for (std::int64_t i = 0; i < count; ++i) {
    std::swap(order[index(i)], order[index(i + random.below(count - i))]);
  }
  std::vector<bool> chosen(index(count), false);
  for (std::int64_t i = 0; i < std::min(frames, count); ++i) chosen[order[index(i)]] = true;
  return chosen;
}

}  // namespace

Problem sub_dataset(const Problem& problem, std::int64_t frames, std::uint64_t seed) {
  const std::vector<bool> cameras = chosen_frames(problem.camera_count(), frames, seed);
  const auto rows = index(problem.observation_count());
  std::vector<int> seen(index(problem.point_count()), 0);
  for (std::size_t i = 0; i < rows; ++i) {
    if (cameras[index(problem.observation_camera[i])]) ++seen[index(problem.observation_point[i])];
  }
  std::vector<bool> points(seen.size());
  std::transform(seen.begin(), seen.end(), points.begin(), [](int n) { return n >= 2; });

  const auto camera_number = renumbered(cameras), point_number = renumbered(points);
  Problem part;
  part.cameras = blocks_of(problem.cameras, cameras, Problem::camera_size);
  part.points = blocks_of(problem.points, points, Problem::point_size);
  for (std::size_t i = 0; i < rows; ++i) {
    const auto camera = camera_number[index(problem.observation_camera[i])];
    const auto point = point_number[index(problem.observation_point[i])];
    if (camera < 0 || point < 0) continue;
    part.observation_camera.push_back(camera);
    part.observation_point.push_back(point);
    part.observations.push_back(problem.observations[2 * i]);
    part.observations.push_back(problem.observations[2 * i + 1]);
  }
  return part;
}

Linearised::Linearised(const Problem& problem, linalg::ThreadPool& threads)
    : pool(threads),
      objective(problem, {.pose_update = PoseUpdate::global}, threads),
      J(objective.layout()),
      normal(objective.layout()),
      residual(index(objective.layout().residuals())) {}

double Linearised::at(const State& state) {
  return objective.linearize(state, J, normal, residual.data());
}

Json residuals(const Problem& problem, linalg::ThreadPool& pool) {
  Linearised linearised(problem, pool);
  const double cost = linearised.at(linearised.objective.state_of(problem));
  // The objective's order of rows.
  std::vector<std::size_t> order(index(problem.observation_count()));
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const auto key = [&](std::size_t i) {
      return std::pair(problem.observation_point[i], problem.observation_camera[i]);
    };
    return key(a) < key(b);
  });
  Json rows = Json::array();
  for (std::size_t row = 0; row < order.size(); ++row) {
    const std::size_t i = order[row];
    const double x = problem.observations[2 * i], y = problem.observations[2 * i + 1];
    rows.push_back({problem.observation_camera[i], x, y, x + linearised.residual[2 * row],
                    y + linearised.residual[2 * row + 1]});
  }
  return {{"cost", cost}, {"rows", std::move(rows)}, {"gradient", linearised.normal.gradient}};
}

Json geometry(const Problem& problem) {
  return {{"cameras", camera_centres(problem)}, {"points", problem.points}};
}

}  // namespace raybundle::bench
