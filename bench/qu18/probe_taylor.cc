#include <array>
#include <cmath>

#include <Eigen/Core>

#include <raybundle/bench/qu18/probe.h>
#include <raybundle/models/random.h>

namespace raybundle::bench {
namespace {

using Eigen::VectorXd;

/// A random direction whose parts change the image by comparable amounts.
VectorXd random_direction(const linalg::BlockLayout& layout, Random& random) {
  constexpr std::array<double, 9> sizes = {1e-2, 1e-2, 1e-2, 1e-2, 1e-2, 1e-2, 1, 1e-3, 1e-3};
  VectorXd direction(layout.unknowns());
  const auto hubs = layout.size(linalg::Side::hubs);
  for (Eigen::Index i = 0; i < direction.size(); ++i) {
    const double size = i < hubs ? sizes[static_cast<std::size_t>(i % layout.hub_size)] : 1e-2;
    direction[i] = size * random.normal();
  }
  return direction;
}

}  // namespace

Json taylor(const Problem& problem, std::uint64_t seed, linalg::ThreadPool& pool) {
  Linearised at(problem, pool);
  Random random(seed, 1);
  const State start = at.objective.state_of(problem);
  State u = start, moved = start;
  at.objective.retract(start, random_direction(at.layout(), random).data(), u);
  const VectorXd direction = random_direction(at.layout(), random);
  at.at(u);
  const VectorXd F = Eigen::Map<const VectorXd>(at.residual.data(), at.layout().residuals());
  VectorXd derivative(F.size());
  linalg::multiply(at.J, direction.data(), derivative.data(), pool);

  std::vector<double> taus, remainders;
  for (int k = 1; k <= 30; ++k) {
    const double tau = std::ldexp(1.0, -k);
    at.objective.retract(u, VectorXd(tau * direction).data(), moved);
    at.at(moved);
    const Eigen::Map<const VectorXd> G(at.residual.data(), F.size());
    taus.push_back(tau);
    remainders.push_back((G - F - tau * derivative).norm());
  }
  // The slope of the last six steps that stand clear of rounding.
  std::size_t last = 0;
  while (last + 1 < taus.size() && remainders[last + 1] > 1e-11 * F.norm()) ++last;
  const std::size_t first = last >= 5 ? last - 5 : 0;
  const double slope = std::log2(remainders[first] / remainders[last]) /
                       static_cast<double>(std::max<std::size_t>(last - first, 1));
  return {{"tau", taus}, {"remainder", remainders}, {"slope", slope}};
}

}  // namespace raybundle::bench
