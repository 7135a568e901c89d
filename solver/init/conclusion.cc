#include <raybundle/solver/init/conclusion.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/models/error.h>

namespace raybundle::init {

using linalg::index;

const char* name(Ending value) {
  switch (value) {
    case Ending::placed:
      return "placed";
    case Ending::no_pose:
      return "no_pose";
    case Ending::disagreement:
      return "disagreement";
    case Ending::no_parallax:
      return "no_parallax";
    case Ending::not_computable:
      return "not_computable";
    case Ending::interrupted:
      return "interrupted";
  }
  return "?";
}

void refuse_fixed(const Problem& problem) {
  constexpr std::uint16_t pose = 0b111111;
  const char* expected = "none: poses and points are found in a frame of their own";
  for (std::size_t i = 0; i < problem.fixed_camera_parameters.size(); ++i) {
    if ((problem.fixed_camera_parameters[i] & pose) == 0) continue;
    throw InputError("problem", 0, "camera " + std::to_string(i) + " has a fixed pose", expected);
  }
  for (std::size_t p = 0; p < problem.fixed_points.size(); ++p) {
    if (problem.fixed_points[p] == 0) continue;
    throw InputError("problem", 0, "point " + std::to_string(p) + " is fixed", expected);
  }
}

}  // namespace raybundle::init
