// What the values of options are called, and what they imply.

#include <raybundle/solver/methods.h>
#include <raybundle/solver/options.h>

#include <array>

namespace raybundle {
namespace {

template <std::size_t Count, class Enum>
const char* pick(const std::array<const char*, Count>& names, Enum value) {
  return names[static_cast<std::size_t>(value)];
}

}  // namespace

const char* name(Method value) { return traits(value).name; }
const char* name(Elimination value) { return pick(std::array{"none", "points", "cameras"}, value); }
const char* name(Linear value) {
  return pick(
      std::array{"dense-cholesky", "sparse-cholesky", "cholmod", "explicit-pcg", "implicit-pcg"},
      value);
}
const char* name(Preconditioner value) {
  return pick(
      std::array{"identity", "diag-b", "b", "diag-s", "block-diag-s", "two-level", "adaptive"},
      value);
}
const char* name(DiagonalMatrix value) {
  return pick(std::array{"identity", "inc", "diag-h", "held-h"}, value);
}
const char* name(ForcingRule value) {
  return pick(std::array{"thesis", "constant", "eisenstat-walker", "nash-sofer"}, value);
}
const char* name(Loss value) {
  return pick(
      std::array{"none", "huber", "soft-l1", "cauchy", "geman-mcclure", "tukey", "truncated"},
      value);
}
const char* name(LossScope value) { return pick(std::array{"observation", "component"}, value); }
const char* name(PoseUpdate value) { return pick(std::array{"global", "local", "se3"}, value); }
const char* name(Lens value) { return pick(std::array{"free", "fixed"}, value); }
const char* name(PointModel value) { return pick(std::array{"xyz", "idp", "pba", "pmba"}, value); }
const char* name(PointStart value) { return pick(std::array{"problem", "rays"}, value); }
const char* name(PointSteps value) { return pick(std::array{"all", "better", "none"}, value); }
const char* name(ObjectiveKind value) { return pick(std::array{"pixel", "ray"}, value); }
const char* name(Gauge value) { return pick(std::array{"free", "fixed"}, value); }
const char* name(Precision value) { return pick(std::array{"single", "double"}, value); }
const char* name(RayWeight value) { return pick(std::array{"pixel", "focal", "unit"}, value); }

bool needs_schur_complement(Preconditioner value) {
  switch (value) {
    case Preconditioner::diag_s:
    case Preconditioner::block_diag_s:
    case Preconditioner::two_level:
    case Preconditioner::adaptive:
      return true;
    case Preconditioner::identity:
    case Preconditioner::diag_b:
    case Preconditioner::b:
      break;
  }
  return false;
}

}  // namespace raybundle
