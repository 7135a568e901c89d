#include <raybundle/solver/summary.h>

#include <array>

namespace raybundle {
namespace {

struct TerminationInfo {
  const char* name;
  Outcome outcome;
};

constexpr std::array table = {
    TerminationInfo{"gradient_tolerance", Outcome::converged},
    TerminationInfo{"function_tolerance", Outcome::converged},
    TerminationInfo{"parameter_tolerance", Outcome::converged},
    TerminationInfo{"max_iterations", Outcome::limit_reached},
    TerminationInfo{"time_limit", Outcome::limit_reached},
    TerminationInfo{"stopped", Outcome::interrupted},
    TerminationInfo{"damping_limit", Outcome::failed},
    TerminationInfo{"radius_limit", Outcome::failed},
    TerminationInfo{"consecutive_failures", Outcome::failed},
    TerminationInfo{"bad_start", Outcome::failed},
    TerminationInfo{"out_of_memory", Outcome::failed},
};

const TerminationInfo& info(Termination value) { return table[static_cast<std::size_t>(value)]; }

}  // namespace

const char* name(Termination value) { return info(value).name; }
Outcome outcome(Termination value) { return info(value).outcome; }

}  // namespace raybundle
