#include <raybundle/models/observation_rows.h>

#include <raybundle/linalg/block_layout.h>

#include <algorithm>
#include <numeric>

namespace raybundle {

using linalg::index;

ObservationRows::ObservationRows(const Problem& problem)
    : observation(index(problem.observation_count())), begin(index(problem.point_count() + 1), 0) {
  for (const std::int32_t at : problem.observation_point) ++begin[index(at) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::int64_t> next(begin.begin(), begin.end() - 1);
  for (std::int64_t k = 0; k < problem.observation_count(); ++k) {
    observation[index(next[index(problem.observation_point[index(k)])]++)] = k;
  }
  const auto camera_of = [&](std::int64_t k) { return problem.observation_camera[index(k)]; };
  for (std::int64_t i = 0; i < problem.point_count(); ++i) {
    std::stable_sort(observation.begin() + begin[index(i)],
                     observation.begin() + begin[index(i + 1)],
                     [&](auto a, auto b) { return camera_of(a) < camera_of(b); });
  }
  camera.reserve(observation.size());
  point.reserve(observation.size());
  for (const std::int64_t k : observation) {
    camera.push_back(camera_of(k));
    point.push_back(problem.observation_point[index(k)]);
  }
}

std::vector<double> in_row_order(const ObservationRows& rows, const std::vector<double>& values,
                                 std::int64_t size) {
  std::vector<double> ordered;
  ordered.reserve(values.size());
  for (const std::int64_t k : rows.observation) {
    ordered.insert(ordered.end(), values.begin() + k * size, values.begin() + (k + 1) * size);
  }
  return ordered;
}

}  // namespace raybundle
