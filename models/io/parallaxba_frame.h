#pragma once

#include <raybundle/models/rotation.h>

#include <array>

/// ParallaxBA's rotations and ours: its cameras look along +z with y down [Zhao15].
namespace raybundle::io {

/// R_cw from alpha, beta, gamma (radians): diag(1, -1, -1) R_X(gamma) R_Y(beta) R_Z(alpha).
so3::Matrix3 parallaxba_rotation(const std::array<double, 3>& angles);

/// alpha, beta in [-pi/2, pi/2] and gamma of R_cw.
std::array<double, 3> parallaxba_angles(const so3::Matrix3& R_cw);

}  // namespace raybundle::io
