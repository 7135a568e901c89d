#pragma once

#include <string>

#include <raybundle/tools/bench_results.h>

namespace raybundle::tools {

/// The plots of a bench, into plots/ of the plan's folder: cost, cost above the best, and gradient
/// norm over time, cost and gradient norm over iterations, of each problem; a performance profile
/// for each accuracy. Returns what has to be said about them; empty: nothing.
std::string write_plots(const BenchPlan& plan, const BenchResults& results);

}  // namespace raybundle::tools
