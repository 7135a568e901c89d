#pragma once

#include <string>

#include <raybundle/tools/bench_machine.h>
#include <raybundle/tools/bench_results.h>

/// The results of a bench for programs and for people.
namespace raybundle::tools {

/// One line per run; empty where something is not known, inf for an accuracy never reached.
std::string results_csv(const BenchPlan& plan, const BenchResults& results);

/// The same with machine, build, the plan and the profiles; null where the CSV has nothing or inf.
std::string results_json(const BenchPlan& plan, const BenchResults& results,
                         const Machine& machine);

/// Tables in Markdown: the medians per problem and variant, and the profiles at a few ratios with
/// the plots of them that are there.
std::string summary_markdown(const BenchPlan& plan, const BenchResults& results,
                             const Machine& machine);

/// Writes results.csv, results.json, summary.md and plots/ into the plan's folder. Throws
/// std::system_error. Returns what has to be said about the plots; empty: nothing.
std::string write_reports(const BenchPlan& plan);

}  // namespace raybundle::tools
