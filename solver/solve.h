#pragma once

#include <raybundle/linalg/memory.h>
#include <raybundle/models/error.h>
#include <raybundle/models/problem.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/solver/options.h>
#include <raybundle/solver/summary.h>

#include <functional>

namespace raybundle {

enum class Control { proceed, stop };

/// Is shown every iteration as it ends, from the thread that called solve(); may stop the solve.
using Observer = std::function<Control(const IterationRecord&)>;

using linalg::MemoryRefusal;

/// Minimises the cost over everything in `problem` that is not fixed, and writes the best state
/// found into it. Never throws for a numerically hard problem, whose Summary says how it ended.
/// Throws, and then leaves `problem` as it was:
///   InputError          the problem is inconsistent
///   OptionError         options out of range, without effect, or contradicting one another
///   MemoryRefusal       (a std::bad_alloc) it would not fit; its what() has the figures
///   std::system_error   the system refuses a thread
/// and whatever the observer throws. Calls for different problems may run at the same time. Limits
/// and observer act between iterations.
Summary solve(Problem& problem, const Options& options = {}, const Observer& observer = {});

}  // namespace raybundle
