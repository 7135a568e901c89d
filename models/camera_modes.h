#pragma once

#include <raybundle/models/pose.h>

#include <vector>

namespace raybundle {

/// How cameras step when all of them, with what they see, follow one motion that leaves every
/// observation as it is: the seven of a similarity of the world, to first order, in the steps of
/// the pose update; and one for each further unknown (f, by its share of itself; k1; k2).
/// `modes` gets for each camera a row of 7 + (unknowns - 6) numbers per unknown.
void camera_modes(PoseUpdate update, const std::vector<double>& cameras, int unknowns,
                  double* modes);

}  // namespace raybundle
