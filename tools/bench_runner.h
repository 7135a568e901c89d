#pragma once

#include <raybundle/tools/bench_plan.h>
#include <raybundle/tools/interrupt.h>

/// Carries out the plan of a bench.
namespace raybundle::tools {

struct RunCounts {
  int done = 0;
  int kept = 0;     ///< of an earlier call
  int refused = 0;  ///< among those done: the program did not take options or problem, or an error
  bool interrupted = false;
};

/// Makes the scenes that are not there, then runs whatever has not been run: round by round, in
/// each problem by problem, variant by variant, so that a disturbance of the machine hits all
/// alike. Tells of every run on standard error. Returns early after an interruption. Throws
/// InputError for a problem that is not there or cannot be generated, std::system_error for what
/// cannot be written.
RunCounts run_plan(const BenchPlan& plan, const InterruptGuard& interrupt);

}  // namespace raybundle::tools
