#include <raybundle/solver/init/restriction.h>

#include <raybundle/linalg/block_layout.h>

#include <algorithm>

namespace raybundle::init {
namespace {

using linalg::index;

// The places of what is marked, and for each its new number; -1: none.
struct Numbering {
  std::vector<std::int32_t> kept, number;

  explicit Numbering(std::span<const std::uint8_t> marks) : number(marks.size(), -1) {
    for (std::size_t i = 0; i < marks.size(); ++i) {
      if (marks[i] == 0) continue;
      number[i] = static_cast<std::int32_t>(kept.size());
      kept.push_back(static_cast<std::int32_t>(i));
    }
  }
};

template <class T>
void copy_blocks(const std::vector<T>& from, std::span<const std::int32_t> kept, std::int64_t size,
                 std::vector<T>& to) {
  if (from.empty()) return;
  for (const std::int32_t i : kept) {
    const auto first = from.begin() + i * size;
    to.insert(to.end(), first, first + size);
  }
}

}  // namespace

Restriction restricted(const Problem& problem, const Marks& marks) {
  const auto is_kept = [&](std::int64_t k) {
    return marks.observations[index(k)] != 0 &&
           marks.images[index(problem.observation_camera[index(k)])] != 0 &&
           marks.points[index(problem.observation_point[index(k)])] != 0;
  };
  Restriction result;
  std::vector<std::uint8_t> seen(marks.points.size(), 0);
  for (std::int64_t k = 0; k < problem.observation_count(); ++k) {
    if (!is_kept(k)) continue;
    result.observation.push_back(k);
    seen[index(problem.observation_point[index(k)])] = 1;
  }
  Numbering of_images(marks.images), of_points(seen);
  Problem& part = result.problem;
  part.aspect = problem.aspect;
  copy_blocks(problem.cameras, of_images.kept, Problem::camera_size, part.cameras);
  copy_blocks(problem.points, of_points.kept, Problem::point_size, part.points);
  copy_blocks(problem.fixed_camera_parameters, of_images.kept, 1, part.fixed_camera_parameters);
  copy_blocks(problem.fixed_points, of_points.kept, 1, part.fixed_points);
  for (const std::int64_t k : result.observation) {
    part.observation_camera.push_back(
        of_images.number[index(problem.observation_camera[index(k)])]);
    part.observation_point.push_back(of_points.number[index(problem.observation_point[index(k)])]);
    part.observations.push_back(problem.observations[index(2 * k)]);
    part.observations.push_back(problem.observations[index(2 * k + 1)]);
  }
  result.image = std::move(of_images.kept);
  result.point = std::move(of_points.kept);
  return result;
}

void Restriction::write_back(Problem& whole) const {
  for (std::size_t i = 0; i < image.size(); ++i) {
    std::copy_n(problem.cameras.begin() + static_cast<std::ptrdiff_t>(Problem::camera_size * i),
                Problem::camera_size,
                whole.cameras.begin() + std::ptrdiff_t{Problem::camera_size} * image[i]);
  }
  for (std::size_t p = 0; p < point.size(); ++p) {
    std::copy_n(problem.points.begin() + static_cast<std::ptrdiff_t>(Problem::point_size * p),
                Problem::point_size,
                whole.points.begin() + std::ptrdiff_t{Problem::point_size} * point[p]);
  }
}

}  // namespace raybundle::init
