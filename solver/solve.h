#pragma once

#include <raybundle/models/problem.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/solver/options.h>
#include <raybundle/solver/summary.h>

#include <functional>

namespace raybundle {

enum class Control { proceed, stop };

/// Is shown every iteration as it ends, from the thread that called solve(); may stop the solve.
using Observer = std::function<Control(const IterationRecord&)>;

/// Minimises the cost over everything in `problem` that is not fixed, and writes the best state
/// found into it. Throws InputError for an inconsistent problem and OptionError for options that
/// make no sense together; never for a numerically hard problem, whose Summary says how it ended.
Summary solve(Problem& problem, const Options& options = {}, const Observer& observer = {});

}  // namespace raybundle
