#pragma once

#include <chrono>

namespace raybundle {

/// Adds its lifetime, in seconds, to a phase.
class PhaseTimer {
 public:
  explicit PhaseTimer(double& phase) : phase_(phase) {}
  ~PhaseTimer() { phase_ += std::chrono::duration<double>(Clock::now() - start_).count(); }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  using Clock = std::chrono::steady_clock;

  double& phase_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace raybundle
