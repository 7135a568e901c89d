#pragma once

#include <raybundle/solver/summary.h>

#include <optional>
#include <string>

namespace raybundle {

/// The tests that end a solve, one iteration at a time.
class Convergence {
 public:
  explicit Convergence(const Options& options) : options_(options) {}

  /// `record` has just ended; `previous_cost` is the cost before it, `next_damping` the mu that the
  /// next iteration would use.
  std::optional<Termination> test(const IterationRecord& record, double previous_cost,
                                  double next_damping);

  /// The reason in words, with the numbers that decided.
  static std::string explain(Termination termination, const Summary& summary);

 private:
  std::optional<Termination> test_accepted(const IterationRecord& record, double previous_cost);
  std::optional<Termination> test_rejected(const IterationRecord& record, double next_damping);

  Options options_;
  int failures_ = 0;
};

}  // namespace raybundle
