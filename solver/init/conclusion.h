#pragma once

#include <raybundle/models/problem.h>
#include <raybundle/solver/solve.h>

#include <cstdint>
#include <functional>
#include <string>

namespace raybundle::init {

/// How an initialisation ended.
enum class Ending {
  placed,          ///< some images have poses, points have places
  no_pose,         ///< no two images have a relative pose, nor a pair to begin with
  disagreement,    ///< no pair agrees with the rotations
  no_parallax,     ///< no two images whose positions the rays tell
  not_computable,  ///< the numbers of a linear system or of an adjustment were of no use
  interrupted,     ///< Progress said stop
};
const char* name(Ending value);

struct Conclusion {
  Ending ending = Ending::placed;
  std::string message;  ///< what was found and what was expected; empty when placed
};

/// Is told what is being done and how far it is, of how much, 0 of 0 where that is not known; says
/// whether to go on. Never called twice at a time, but from any thread.
using Progress = std::function<Control(const char* stage, std::int64_t done, std::int64_t all)>;

/// Throws InputError where a camera's pose or a point is fixed: an initialisation chooses its own
/// frame.
void refuse_fixed(const Problem& problem);

}  // namespace raybundle::init
