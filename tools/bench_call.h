#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <raybundle/tools/bench_plan.h>

/// One call of `raybundle bench`, and what it makes of the arguments that its folder keeps.
namespace raybundle::tools {

/// What was given; nothing stands for what was not. For the meaning see BenchArguments.
struct BenchCall {
  std::vector<std::string> problems = {}, scenes = {}, variants = {}, ceres_variants = {};
  std::vector<std::string> best = {};
  std::optional<std::string> common = {}, ceres = {};  ///< ceres: "none" is without
  std::optional<int> runs = {}, threads = {};
  std::optional<double> time_limit = {};
  std::optional<std::uint64_t> memory_limit = {};
};

/// Whether it says what to run on, so that an earlier call does not matter.
bool names_problems(const BenchCall& call);

/// The arguments with whatever the call gives instead; a cost of --best takes the place of that of
/// the same problem, other lists that of the whole list. Without Ceres there are no variants of it.
BenchArguments changed_by(const BenchCall& call, BenchArguments arguments);

/// Throws OptionError for anything given that does not change a report.
void check_report_call(const BenchCall& call);

}  // namespace raybundle::tools
