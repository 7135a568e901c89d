#pragma once

#include <functional>

#include <raybundle/tools/bench_plan.h>
#include <raybundle/tools/interrupt.h>

/// Carries out the plan of a bench.
namespace raybundle::tools {

struct RunCounts {
  int done = 0;
  int kept = 0;     ///< of an earlier call
  int refused = 0;  ///< among those done: the program did not take options or problem, or an error
  bool accepted = false;  ///< the plan was found good
  bool interrupted = false;
};

/// Checks all of the plan that can be refused and makes the scenes that are not there; calls
/// `accept`, up to which nothing of an earlier bench has changed; then runs whatever has not been
/// run: round by round, in each problem by problem, variant by variant, so that a disturbance of
/// the machine hits all alike. Tells of every run on standard error. Returns early after an
/// interruption. Throws OptionError for options of a variant or a scene, InputError for the files
/// of a problem, std::system_error for what cannot be written.
RunCounts run_plan(const BenchPlan& plan, const InterruptGuard& interrupt,
                   const std::function<void()>& accept);

}  // namespace raybundle::tools
