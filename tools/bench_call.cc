#include <raybundle/tools/bench_call.h>

#include <algorithm>
#include <utility>

#include <raybundle/solver/option_table.h>

namespace raybundle::tools {
namespace {

bool is_given(const std::vector<std::string>& list) { return !list.empty(); }
template <class T>
bool is_given(const std::optional<T>& value) {
  return value.has_value();
}

void take(const std::vector<std::string>& given, std::vector<std::string>& list) {
  if (!given.empty()) list = given;
}
template <class T>
void take(const std::optional<T>& given, T& value) {
  if (given) value = *given;
}

std::string name_of(const std::string& text) { return text.substr(0, text.find('=')); }

void take_best(const std::vector<std::string>& given, std::vector<std::string>& best) {
  for (const std::string& each : given) {
    std::erase_if(best, [&](const std::string& old) { return name_of(old) == name_of(each); });
  }
  best.insert(best.end(), given.begin(), given.end());
}

}  // namespace

bool names_problems(const BenchCall& call) {
  return !call.problems.empty() || !call.scenes.empty();
}

BenchArguments changed_by(const BenchCall& call, BenchArguments arguments) {
  take(call.problems, arguments.problems);
  take(call.scenes, arguments.scenes);
  take(call.variants, arguments.variants);
  take_best(call.best, arguments.best);
  take(call.common, arguments.common);
  take(call.ceres, arguments.ceres);
  if (call.ceres == "none") {
    arguments.ceres.clear();
    arguments.ceres_variants.clear();
  }
  take(call.ceres_variants, arguments.ceres_variants);
  take(call.runs, arguments.runs);
  if (call.threads.value_or(0) > 0) take(call.threads, arguments.threads);
  take(call.time_limit, arguments.time_limit);
  take(call.memory_limit, arguments.memory_limit);
  return arguments;
}

void check_report_call(const BenchCall& call) {
  const auto refuse = [](const char* option, const auto& value) {
    if (is_given(value)) {
      throw OptionError(std::string(option) + " has no effect with --only-report");
    }
  };
  refuse("PROBLEM", call.problems);
  refuse("--scene", call.scenes);
  refuse("--variant", call.variants);
  refuse("--common", call.common);
  refuse("--ceres", call.ceres);
  refuse("--ceres-variant", call.ceres_variants);
  refuse("--runs", call.runs);
  refuse("--threads", call.threads);
  refuse("--time-limit", call.time_limit);
  refuse("--memory-limit", call.memory_limit);
}

}  // namespace raybundle::tools
