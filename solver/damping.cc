#include <raybundle/solver/damping.h>

#include <algorithm>

namespace raybundle {
namespace {

constexpr double smallest_growing = 1e-8;

}  // namespace

void Damping::update(double rho) {
  if (rho > 0) {
    const double t = 2 * rho - 1;
    mu_ = std::max(low_, mu_ * std::max(1.0 / 3.0, 1 - t * t * t));
    nu_ = 2;
  } else {
    mu_ = (mu_ > 0 ? mu_ : smallest_growing) * nu_;
    nu_ *= 2;
  }
}

}  // namespace raybundle
