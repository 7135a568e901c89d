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
  /// `residuals`: how many squares the cost sums.
  Convergence(const Options& options, std::int64_t residuals);

  /// What the next iteration would use; a value that is out of bounds ends the solve.
  struct Next {
    double damping = 0;
    double radius = std::numeric_limits<double>::infinity();
  };

  /// `record` has just ended; `previous_cost` is the cost before it.
  std::optional<Termination> test(const IterationRecord& record, double previous_cost,
                                  const Next& next);

  /// Forgets past failures: the cost is another function now.
  void restart() { failures_ = 0; }

  /// The reason in words, with the numbers that decided.
  static std::string explain(Termination termination, const Summary& summary);

 private:
  std::optional<Termination> test_accepted(const IterationRecord& record, double previous_cost);
  bool is_flat(const IterationRecord& record, double share) const;
  std::optional<Termination> test_rejected(const IterationRecord& record, const Next& next);

  Options options_;
  double cost_resolution_;  // below this share of the cost a change is rounding
  int failures_ = 0;
};

}  // namespace raybundle
