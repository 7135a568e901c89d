#include <raybundle/models/observation_rows.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/linalg/vector.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <utility>

namespace raybundle {
namespace {

using linalg::index;

// Files mostly list their observations so; what is in order needs no list.
bool in_order(const Problem& problem, linalg::ThreadPool& pool) {
  const auto& point = problem.observation_point;
  const auto& camera = problem.observation_camera;
  std::atomic<bool> ordered = true;
  linalg::for_entries(problem.observation_count() - 1, pool, [&](std::size_t k) {
    const bool after =
        point[k] < point[k + 1] || (point[k] == point[k + 1] && camera[k] <= camera[k + 1]);
    if (!after) ordered.store(false, std::memory_order_relaxed);
  });
  return ordered;
}

// Where the rows of each point begin in a list of points that ascends.
void find_begins(const std::vector<std::int32_t>& point, linalg::LargeVector<std::int64_t>& begin,
                 linalg::ThreadPool& pool) {
  linalg::for_entries(static_cast<std::int64_t>(point.size()), pool, [&](std::size_t k) {
    const std::int64_t before = k == 0 ? -1 : point[k - 1];
    std::fill(begin.begin() + before + 1, begin.begin() + point[k] + 1,
              static_cast<std::int64_t>(k));
  });
  const std::int64_t last = point.empty() ? -1 : point.back();
  std::fill(begin.begin() + last + 1, begin.end(), static_cast<std::int64_t>(point.size()));
}

// A counting sort by point, and of each point by camera.
void sort_observations(const Problem& problem, ObservationRows& rows, linalg::ThreadPool& pool) {
  linalg::LargeVector<std::int64_t>& begin = rows.begin;
  for (const std::int32_t at : problem.observation_point) ++begin[index(at) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::int64_t> next(begin.begin(), begin.end() - 1);
  rows.observation.resize(index(problem.observation_count()));
  for (std::int64_t k = 0; k < problem.observation_count(); ++k) {
    const std::size_t at = index(next[index(problem.observation_point[index(k)])]++);
    rows.observation[at] = static_cast<std::int32_t>(k);
  }
  const auto key = [&](std::int32_t k) {
    return std::pair(problem.observation_camera[index(k)], k);
  };
  const auto by_camera = [&](std::int32_t a, std::int32_t b) { return key(a) < key(b); };
  linalg::parallel_for(pool, problem.point_count(), 1024,
                       [&](std::int64_t first, std::int64_t last) {
                         for (std::int64_t i = first; i < last; ++i) {
                           std::sort(rows.observation.begin() + begin[index(i)],
                                     rows.observation.begin() + begin[index(i + 1)], by_camera);
                         }
                       });
}

}  // namespace

bool is_in_row_order(const Problem& problem) {
  linalg::ThreadPool alone(1);
  return in_order(problem, alone);
}

ObservationRows::ObservationRows(const Problem& problem, linalg::ThreadPool& pool)
    : camera(index(problem.observation_count())),
      point(index(problem.observation_count())),
      begin(index(problem.point_count() + 1), 0) {
  if (in_order(problem, pool)) {
    find_begins(problem.observation_point, begin, pool);
  } else {
    sort_observations(problem, *this, pool);
  }
  linalg::for_entries(count(), pool, [&](std::size_t row) {
    const std::size_t k = index(observation_of(static_cast<std::int64_t>(row)));
    camera[row] = problem.observation_camera[k];
    point[row] = problem.observation_point[k];
  });
}

linalg::LargeVector<double> in_row_order(const ObservationRows& rows,
                                         const std::vector<double>& values, std::int64_t size,
                                         linalg::ThreadPool& pool) {
  linalg::LargeVector<double> ordered(values.size());
  linalg::parallel_for(pool, rows.count(), 16384, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t row = first; row < last; ++row) {
      std::copy_n(values.data() + size * rows.observation_of(row), size,
                  ordered.data() + size * row);
    }
  });
  return ordered;
}

}  // namespace raybundle
