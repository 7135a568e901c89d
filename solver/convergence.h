#pragma once

#include <raybundle/solver/summary.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace raybundle {

/// The tests that end a solve, one iteration at a time.
class Convergence {
 public:
  /// `residuals`: how many squares the cost sums; a cost up to `rounding` is none.
  Convergence(const Options& options, std::int64_t residuals, double rounding = 0);

  /// What else is known when an iteration has ended.
  struct Situation {
    double previous_cost = 0;  ///< before the iteration
    double next_damping = 0;   ///< of the next iteration; past its limit the solve ends
    double next_radius = std::numeric_limits<double>::infinity();  ///< likewise
    /// A lower bound of what the undamped, unbounded model still promises. Damping, radius and
    /// limits of the inner iterations can make any step small: that alone is not convergence.
    double promise = 0;
  };

  /// Whether the solve has converged or failed with the iteration that `record` ends.
  std::optional<Termination> test(const IterationRecord& record, const Situation& situation);
  /// Whether it is over in any case.
  std::optional<Termination> limit(const IterationRecord& record) const;

  /// Forgets past failures: the cost is another function now.
  void restart() { failures_ = 0; }

  /// The reason in words, with the numbers that decided.
  static std::string explain(Termination termination, const Summary& summary);

 private:
  /// Below this a change of the cost is rounding.
  double resolution(double cost) const;
  std::optional<Termination> test_accepted(const IterationRecord& record,
                                           const Situation& situation);
  std::optional<Termination> test_rejected(const IterationRecord& record,
                                           const Situation& situation);

  Options options_;
  double rounding_;
  double residuals_;
  int failures_ = 0;
};

}  // namespace raybundle
