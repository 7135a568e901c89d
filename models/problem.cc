#include <raybundle/models/problem.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <string>

#include <raybundle/models/error.h>

namespace raybundle {
namespace {

[[noreturn]] void fail(const std::string& found, const std::string& expected) {
  throw InputError("problem", 0, found, expected);
}

void check_size(const char* what, std::size_t size, std::size_t expected) {
  if (size == expected) return;
  fail(std::to_string(size) + " " + what, std::to_string(expected));
}

void check_count(const char* what, std::int64_t count) {
  if (count < 1) fail("0 " + std::string(what), "at least 1");
}

// The first i below `count` with bad(i), or `count`.
template <class Bad>
std::int64_t find_first(std::int64_t count, linalg::ThreadPool& pool, Bad&& bad) {
  std::atomic<std::int64_t> found = count;
  linalg::parallel_for(pool, count, 16384, [&](std::int64_t first, std::int64_t last) {
    while (first < last && !bad(static_cast<std::size_t>(first))) ++first;
    if (first == last) return;
    std::int64_t least = found.load();
    while (first < least && !found.compare_exchange_weak(least, first)) {
    }
  });
  return found;
}

void check_indices(const char* what, const std::vector<std::int32_t>& indices, std::int64_t count,
                   linalg::ThreadPool& pool) {
  const auto size = static_cast<std::int64_t>(indices.size());
  const std::int64_t bad =
      find_first(size, pool, [&](std::size_t i) { return indices[i] < 0 || indices[i] >= count; });
  if (bad == size) return;
  fail(std::string(what) + " " + std::to_string(indices[static_cast<std::size_t>(bad)]) +
           " in observation " + std::to_string(bad),
       "0 to " + std::to_string(count - 1));
}

void check_finite(const char* what, const std::vector<double>& values, int size,
                  linalg::ThreadPool& pool) {
  const auto count = static_cast<std::int64_t>(values.size());
  const std::int64_t bad =
      find_first(count, pool, [&](std::size_t i) { return !std::isfinite(values[i]); });
  if (bad == count) return;
  fail(std::to_string(values[static_cast<std::size_t>(bad)]) + " in " + what + " " +
           std::to_string(bad / size),
       "a finite number");
}

}  // namespace

void validate(const Problem& problem) {
  linalg::ThreadPool alone(1);
  validate(problem, alone);
}

void validate_sizes(const Problem& problem) {
  if (problem.cameras.size() % Problem::camera_size != 0) {
    fail(std::to_string(problem.cameras.size()) + " camera parameters", "a multiple of 9");
  }
  if (problem.points.size() % Problem::point_size != 0) {
    fail(std::to_string(problem.points.size()) + " point coordinates", "a multiple of 3");
  }
  check_count("cameras", problem.camera_count());
  check_count("points", problem.point_count());
  check_count("observations", problem.observation_count());
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  if (problem.observation_count() > most) {
    fail(std::to_string(problem.observation_count()) + " observations",
         "at most " + std::to_string(most));
  }

  const std::size_t observations = problem.observation_camera.size();
  check_size("point indices of observations", problem.observation_point.size(), observations);
  check_size("image coordinates of observations", problem.observations.size(), 2 * observations);
  if (!problem.fixed_camera_parameters.empty()) {
    check_size("masks of fixed camera parameters", problem.fixed_camera_parameters.size(),
               static_cast<std::size_t>(problem.camera_count()));
  }
  if (!problem.fixed_points.empty()) {
    check_size("marks of fixed points", problem.fixed_points.size(),
               static_cast<std::size_t>(problem.point_count()));
  }
}

void validate(const Problem& problem, linalg::ThreadPool& pool) {
  validate_sizes(problem);
  for (const std::uint16_t mask : problem.fixed_camera_parameters) {
    if (mask >> Problem::camera_size != 0) {
      fail("a mask of " + std::to_string(mask) + " for fixed camera parameters", "nine bits");
    }
  }

  check_indices("camera", problem.observation_camera, problem.camera_count(), pool);
  check_indices("point", problem.observation_point, problem.point_count(), pool);
  check_finite("camera", problem.cameras, Problem::camera_size, pool);
  check_finite("point", problem.points, Problem::point_size, pool);
  check_finite("observation", problem.observations, 2, pool);
  if (!(problem.aspect > 0) || !std::isfinite(problem.aspect)) {
    fail("an aspect of " + std::to_string(problem.aspect), "a finite number above 0");
  }
}

}  // namespace raybundle
