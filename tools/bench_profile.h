#pragma once

#include <vector>

/// How solvers are compared on many problems: performance profiles [DolanMore02, Sec. 2] with the
/// convergence test of [MoreWild09, Eq. 2.2], as bundle adjustment papers use them [Kushal12].
namespace raybundle::tools {

/// One state of a solve that is kept, in the order of time.
struct CostAt {
  double seconds;
  double cost;
};

/// The cost that counts as solved to within `tau`: best + tau (start - best).
double target_cost(double start, double best, double tau);

/// When the cost was first at most `target`; infinity: never. A cost that is not finite counts as
/// not reached.
double seconds_to(const std::vector<CostAt>& trace, double target);

/// The middle value, of an even number the mean of the two in the middle; NaN for none. Infinities
/// are values like others, NaNs count as infinite.
double median(std::vector<double> values);

/// Performance profile of one solver: the share of all problems that it solves within `ratio` times
/// the time of the fastest solver on each. A step function: share[i] holds from ratio[i] on.
struct Profile {
  std::vector<double> ratio;  ///< ascending, from 1
  std::vector<double> share;
};

/// `seconds[p][v]`: time of solver v on problem p, infinite where it does not solve it. Problems
/// that nobody solves count as unsolved by all. One profile per solver.
std::vector<Profile> profiles(const std::vector<std::vector<double>>& seconds);

/// The value of a profile at `ratio`.
double share_at(const Profile& profile, double ratio);

}  // namespace raybundle::tools
