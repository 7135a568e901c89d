#include <raybundle/models/rays.h>

#include <raybundle/models/error.h>
#include <raybundle/models/statistics.h>

#include <cmath>
#include <limits>
#include <string>

namespace raybundle {
namespace {

// Where r (1 + k1 r^2 + k2 r^4) first stops growing: the smallest root of 1 + 3 k1 t + 5 k2 t^2 in
// t = r^2 > 0, if any.
double turning_radius(double k1, double k2) {
  const double half = 1.5 * k1;
  const double discriminant = half * half - 5 * k2;
  constexpr double none = std::numeric_limits<double>::infinity();
  if (discriminant < 0) return none;
  // 1 / t = -half -+ root: the smallest positive t is the largest of these.
  const double root = std::sqrt(discriminant);
  const double inverse = half > 0 ? -5 * k2 / (half + root) : root - half;  // nothing cancels
  return inverse > 0 ? std::sqrt(1 / inverse) : none;
}

// The r with r (1 + k1 r^2 + k2 r^4) = target on the branch through 0: Newton's iteration, kept in
// a bracket.
double undistorted_radius(double k1, double k2, double target, double low, double high) {
  double r = std::min(target, high);
  for (int i = 0; i < 200 && low < high; ++i) {
    const double t = r * r;
    const double error = r * (1 + t * (k1 + t * k2)) - target;
    (error > 0 ? high : low) = r;
    double next = r - error / (1 + t * (3 * k1 + 5 * t * k2));
    if (!(next > low && next < high)) next = low + 0.5 * (high - low);
    if (std::abs(next - r) <= 4e-16 * r) return next;
    r = next;
  }
  return r;
}

std::array<double, 2> fail_unreachable(std::size_t k, std::size_t camera,
                                       const std::array<double, 2>& u,
                                       const std::string& alternative) {
  throw InputError("problem", 0,
                   "observation " + std::to_string(k) + " at (" + std::to_string(u[0]) + ", " +
                       std::to_string(u[1]) + "), which the lens of camera " +
                       std::to_string(camera) + " cannot make",
                   "pixels that f, k1 and k2 reach" + alternative);
}

// Rays of all observations; `folded` says what to take for p where there is none.
template <class Folded>
std::vector<double> rays_of(const Problem& problem, Folded&& folded) {
  std::vector<double> rays;
  rays.reserve(3 * problem.observation_camera.size());
  for (std::size_t k = 0; k < problem.observation_camera.size(); ++k) {
    const auto camera = static_cast<std::size_t>(problem.observation_camera[k]);
    const double* lens = problem.cameras.data() + Problem::camera_size * camera + 6;
    const double* observed = problem.observations.data() + 2 * k;
    const std::array<double, 2> u = {observed[0], observed[1] / problem.aspect};
    const auto found = undistort(lens, u.data());
    const std::array<double, 2> p = found ? *found : folded(k, camera, u);
    const double inverse = 1 / std::sqrt(p[0] * p[0] + p[1] * p[1] + 1);
    rays.insert(rays.end(), {p[0] * inverse, p[1] * inverse, -inverse});
  }
  return rays;
}

}  // namespace

std::optional<std::array<double, 2>> undistort(const double* lens, const double* u) {
  const double distorted[2] = {u[0] / lens[0], u[1] / lens[0]};
  const double target = std::hypot(distorted[0], distorted[1]);
  if (!std::isfinite(target)) return std::nullopt;
  if (target == 0) return std::array<double, 2>{0, 0};
  const double k1 = lens[1], k2 = lens[2];
  if (k1 == 0 && k2 == 0) return std::array<double, 2>{distorted[0], distorted[1]};
  double high = turning_radius(k1, k2);
  if (std::isinf(high)) {
    high = 2 * target + 1;  // it grows for ever: far enough is found by doubling
    while (high * (1 + high * high * (k1 + high * high * k2)) < target) high *= 2;
  } else if (high * (1 + high * high * (k1 + high * high * k2)) < target) {
    return std::nullopt;
  }
  const double scale = undistorted_radius(k1, k2, target, 0, high) / target;
  return std::array<double, 2>{scale * distorted[0], scale * distorted[1]};
}

std::vector<double> observed_rays(const Problem& problem) {
  return rays_of(problem, [](std::size_t k, std::size_t camera, const auto& u) {
    return fail_unreachable(k, camera, u, ", or the pixel objective");
  });
}

std::vector<double> apparent_rays(const Problem& problem) {
  return rays_of(problem,
                 [&](std::size_t, std::size_t camera, const auto& u) -> std::array<double, 2> {
                   const double f = problem.cameras[Problem::camera_size * camera + 6];
                   if (f == 0) return {0, 0};
                   return {u[0] / f, u[1] / f};
                 });
}

Problem undistorted(Problem problem) {
  for (std::size_t k = 0; k < problem.observation_camera.size(); ++k) {
    const auto camera = static_cast<std::size_t>(problem.observation_camera[k]);
    const double* lens = problem.cameras.data() + Problem::camera_size * camera + 6;
    if (lens[1] == 0 && lens[2] == 0) continue;  // to the last digit as it was
    double* observed = problem.observations.data() + 2 * k;
    const std::array<double, 2> u = {observed[0], observed[1] / problem.aspect};
    const auto found = undistort(lens, u.data());
    const std::array<double, 2> p = found ? *found : fail_unreachable(k, camera, u, "");
    observed[0] = lens[0] * p[0];
    observed[1] = problem.aspect * lens[0] * p[1];
  }
  for (std::size_t c = 0; c < problem.cameras.size(); c += Problem::camera_size) {
    problem.cameras[c + 7] = problem.cameras[c + 8] = 0;
  }
  return problem;
}

Problem with_one_focal_length(Problem problem) {
  const auto focal = [&](std::size_t camera) -> double& {
    return problem.cameras[Problem::camera_size * camera + 6];
  };
  std::vector<double> used;
  std::vector<bool> counted(problem.cameras.size() / Problem::camera_size);
  for (const std::int32_t camera : problem.observation_camera) {
    const auto c = static_cast<std::size_t>(camera);
    if (!counted[c]) used.push_back(focal(c));
    counted[c] = true;
  }
  for (std::size_t c = 0; used.empty() && c < counted.size(); ++c) used.push_back(focal(c));
  const double common = upper_median(used);
  for (std::size_t k = 0; k < problem.observation_camera.size(); ++k) {
    const auto camera = static_cast<std::size_t>(problem.observation_camera[k]);
    if (focal(camera) == common) continue;
    if (focal(camera) == 0) {
      throw InputError("problem", 0, "camera " + std::to_string(camera) + " with f 0",
                       "a focal length that makes pixels of rays");
    }
    for (std::size_t i = 2 * k; i < 2 * k + 2; ++i) {
      problem.observations[i] *= common / focal(camera);
    }
  }
  for (std::size_t c = 0; c < counted.size(); ++c) focal(c) = common;
  return problem;
}

}  // namespace raybundle
