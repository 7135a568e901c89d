#include <raybundle/models/problem.h>

#include <algorithm>
#include <cmath>
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

void check_indices(const char* what, const std::vector<std::int32_t>& indices, std::int64_t count) {
  const auto bad = std::find_if(indices.begin(), indices.end(),
                                [&](std::int32_t index) { return index < 0 || index >= count; });
  if (bad == indices.end()) return;
  fail(std::string(what) + " " + std::to_string(*bad) + " in observation " +
           std::to_string(bad - indices.begin()),
       "0 to " + std::to_string(count - 1));
}

void check_finite(const char* what, const std::vector<double>& values, int size) {
  const auto bad = std::find_if(values.begin(), values.end(),
                                [](double value) { return !std::isfinite(value); });
  if (bad == values.end()) return;
  fail(std::to_string(*bad) + " in " + what + " " + std::to_string((bad - values.begin()) / size),
       "a finite number");
}

}  // namespace

void validate(const Problem& problem) {
  if (problem.cameras.size() % Problem::camera_size != 0) {
    fail(std::to_string(problem.cameras.size()) + " camera parameters", "a multiple of 9");
  }
  if (problem.points.size() % Problem::point_size != 0) {
    fail(std::to_string(problem.points.size()) + " point coordinates", "a multiple of 3");
  }
  check_count("cameras", problem.camera_count());
  check_count("points", problem.point_count());
  check_count("observations", problem.observation_count());

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
  for (const std::uint16_t mask : problem.fixed_camera_parameters) {
    if (mask >> Problem::camera_size != 0) {
      fail("a mask of " + std::to_string(mask) + " for fixed camera parameters", "nine bits");
    }
  }

  check_indices("camera", problem.observation_camera, problem.camera_count());
  check_indices("point", problem.observation_point, problem.point_count());
  check_finite("camera", problem.cameras, Problem::camera_size);
  check_finite("point", problem.points, Problem::point_size);
  check_finite("observation", problem.observations, 2);
  if (!(problem.aspect > 0) || !std::isfinite(problem.aspect)) {
    fail("an aspect of " + std::to_string(problem.aspect), "a finite number above 0");
  }
}

}  // namespace raybundle
