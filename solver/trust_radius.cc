#include <raybundle/solver/trust_radius.h>

#include <algorithm>
#include <cmath>

namespace raybundle {

void TrustRadius::update(double rho, bool on_boundary, double length) {
  if (std::isinf(radius_) && length > 0 && std::isfinite(length)) radius_ = length;
  if (!(rho >= 0.25)) {
    radius_ = rule_.shrink * (length > 0 ? std::min(radius_, length) : radius_);
  } else if (rho > 0.75 && on_boundary) {
    radius_ *= rule_.grow;
  }
}

}  // namespace raybundle
