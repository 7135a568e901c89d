#pragma once

namespace raybundle::init {

/// Where a few damped steps lead from `state`, for problems of a handful of unknowns: the next one
/// is propose(state, damping), and is taken where it lowers cost(state).
template <class State, class Cost, class Propose>
State small_descent(State state, Cost&& cost, Propose&& propose) {
  constexpr int most_steps = 20;
  double at = cost(state), damping = 1e-4;
  for (int k = 0; k < most_steps && damping < 1e4; ++k) {
    const State next = propose(state, damping);
    const double there = cost(next);
    if (!(there < at)) {
      damping *= 10;
      continue;
    }
    const bool done = at - there < 1e-10 * at;
    state = next;
    at = there;
    damping *= 0.1;
    if (done) break;
  }
  return state;
}

}  // namespace raybundle::init
