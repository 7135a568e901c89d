#include <raybundle/tools/bench_results.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <nlohmann/json.hpp>

namespace raybundle::tools {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr double infinity = std::numeric_limits<double>::infinity();

double number(const Json& json, const char* key) {
  const auto member = json.find(key);
  return member != json.end() && member->is_number() ? member->get<double>() : NAN;
}
int whole(const Json& json, const char* key) {
  const auto member = json.find(key);
  return member != json.end() && member->is_number_integer() ? member->get<int>() : -1;
}

Json parse(const fs::path& file) {
  Json json = Json::parse(file_text(file), nullptr, false);
  return json.is_object() ? json : Json::object();
}

void read_log(const Json& log, RunResult& result) {
  const Json iterations = log.value("iterations", Json::array());
  for (const Json& each : iterations) {
    result.trace.push_back({whole(each, "iteration"), number(each, "seconds"), number(each, "cost"),
                            number(each, "gradient_norm")});
  }
  const Json options = log.value("options", Json::object());
  const auto loss = options.find("loss");
  result.robust = loss != options.end() && loss->is_string() && *loss != "none";
  const Json summary = log.value("summary", Json::object());
  result.termination = summary.value("termination", "");
  result.initial_cost = number(summary, "initial_cost");
  result.final_cost = number(summary, "final_cost");
  result.gradient_norm = number(summary, "gradient_norm");
  result.inner_iterations = whole(summary, "inner_iterations");
  result.seconds = number(summary.value("seconds", Json::object()), "total");
  if (result.trace.empty()) return;
  result.iterations = result.trace.back().iteration;
  // The rival's log says it only there.
  if (std::isnan(result.gradient_norm)) result.gradient_norm = result.trace.back().gradient_norm;
}

std::string status_text(const std::map<std::string, int>& counts) {
  if (counts.size() == 1) return counts.begin()->first;
  std::string text;
  for (const auto& [status, count] : counts) {
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + status;
  }
  return text;
}

/// The median of one value over runs, leaving out those that do not have it.
template <class Value>
double median_of(const std::vector<const RunResult*>& runs, Value value) {
  std::vector<double> values;
  for (const RunResult* run : runs) {
    const auto each = static_cast<double>(value(*run));
    if (!std::isnan(each)) values.push_back(each);
  }
  return median(std::move(values));
}

double known(std::int64_t value) { return value < 0 ? NAN : static_cast<double>(value); }

const RunResult* middle_run(std::vector<const RunResult*> runs) {
  std::erase_if(runs, [](const RunResult* run) { return run->trace.empty(); });
  if (runs.empty()) return nullptr;
  std::stable_sort(runs.begin(), runs.end(), [](const RunResult* a, const RunResult* b) {
    return a->trace.back().seconds < b->trace.back().seconds;
  });
  return runs[(runs.size() - 1) / 2];
}

bool was_carried_out(RunStatus status) {
  return status != RunStatus::refused && status != RunStatus::error &&
         status != RunStatus::interrupted;
}

MedianResult median_result(const std::vector<const RunResult*>& runs) {
  MedianResult all{};
  all.problem = runs.front()->problem;
  all.variant = runs.front()->variant;
  std::map<std::string, int> counts;
  for (const RunResult* run : runs) ++counts[name(run->status)];
  all.status = status_text(counts);
  all.carried_out = std::any_of(runs.begin(), runs.end(),
                                [](const RunResult* r) { return was_carried_out(r->status); });
  all.compared = std::all_of(runs.begin(), runs.end(),
                             [](const RunResult* r) { return r->compared || r->trace.empty(); });
  all.final_cost = median_of(runs, [](const RunResult& r) { return r.final_cost; });
  all.gradient_norm = median_of(runs, [](const RunResult& r) { return r.gradient_norm; });
  all.iterations = median_of(runs, [](const RunResult& r) { return known(r.iterations); });
  all.inner_iterations =
      median_of(runs, [](const RunResult& r) { return known(r.inner_iterations); });
  all.seconds = median_of(runs, [](const RunResult& r) { return r.seconds; });
  for (std::size_t i = 0; i < accuracies.size(); ++i) {
    all.seconds_to[i] = median_of(runs, [i](const RunResult& r) { return r.seconds_to[i]; });
  }
  all.peak_bytes = median_of(runs, [](const RunResult& r) { return known(r.peak_bytes); });
  all.camera_rmse = median_of(runs, [](const RunResult& r) { return r.camera_rmse; });
  all.point_rmse = median_of(runs, [](const RunResult& r) { return r.point_rmse; });
  all.middle = middle_run(runs);
  return all;
}

}  // namespace

RunResult read_run(const BenchPlan& plan, const BenchProblem& problem, const BenchVariant& variant,
                   int run) {
  const std::string base = plan.run_path(problem, variant, run).string();
  RunResult result;
  result.problem = static_cast<std::size_t>(&problem - plan.problems.data());
  result.variant = static_cast<std::size_t>(&variant - plan.variants.data());
  result.run = run;
  result.seconds_to.fill(infinity);
  const auto outcome = load_outcome(base + ".run.json");
  if (!outcome) return result;
  result.status = outcome->status;
  result.message = outcome->message;
  result.peak_bytes = outcome->peak_bytes;
  try {
    read_log(parse(base + ".json"), result);
    const Json truth = parse(base + ".eval.json").value("truth", Json::object());
    result.camera_rmse = number(truth, "camera_rmse");
    result.point_rmse = number(truth, "point_rmse");
  } catch (const Json::exception& error) {  // not a log at all
    result.message = error.what();
    result.trace.clear();
  }
  return result;
}

void complete(const BenchPlan& plan, BenchResults& results) {
  results.start.assign(plan.problems.size(), NAN);
  results.best.clear();
  for (const BenchProblem& problem : plan.problems) results.best.push_back(problem.best);
  std::vector<bool> has_plain(plan.problems.size(), false);
  for (const RunResult& run : results.runs) {
    if (!run.robust && !run.trace.empty()) has_plain[run.problem] = true;
  }
  for (RunResult& run : results.runs) {
    run.compared = !run.trace.empty() && !(run.robust && has_plain[run.problem]);
    if (!run.compared) continue;
    double& start = results.start[run.problem];
    if (std::isnan(start)) start = run.trace.front().cost;
    for (const Iterate& each : run.trace) {
      if (each.cost < results.best[run.problem]) results.best[run.problem] = each.cost;
    }
  }
  for (RunResult& run : results.runs) {
    run.seconds_to.fill(infinity);
    if (!run.compared) continue;
    std::vector<CostAt> trace;
    for (const Iterate& each : run.trace) trace.push_back({each.seconds, each.cost});
    for (std::size_t i = 0; i < accuracies.size(); ++i) {
      const double target =
          target_cost(results.start[run.problem], results.best[run.problem], accuracies[i]);
      run.seconds_to[i] = seconds_to(trace, target);
    }
  }
}

BenchResults read_results(const BenchPlan& plan) {
  BenchResults results;
  for (const BenchProblem& problem : plan.problems) {
    for (const BenchVariant& variant : plan.variants) {
      for (int run = 1; run <= plan.arguments.runs; ++run) {
        const auto outcome =
            load_outcome(plan.run_path(problem, variant, run).string() + ".run.json");
        if (!outcome || !is_of_variant(outcome->stamp, variant, plan.arguments)) continue;
        results.runs.push_back(read_run(plan, problem, variant, run));
      }
    }
  }
  complete(plan, results);
  return results;
}

std::vector<MedianResult> medians(const BenchPlan& plan, const BenchResults& results) {
  std::vector<MedianResult> all;
  for (std::size_t p = 0; p < plan.problems.size(); ++p) {
    for (std::size_t v = 0; v < plan.variants.size(); ++v) {
      std::vector<const RunResult*> runs;
      for (const RunResult& run : results.runs) {
        if (run.problem == p && run.variant == v) runs.push_back(&run);
      }
      if (!runs.empty()) all.push_back(median_result(runs));
    }
  }
  return all;
}

std::vector<bool> problems_run(const BenchPlan& plan, const std::vector<MedianResult>& medians) {
  std::vector<bool> run(plan.problems.size(), false);
  for (const MedianResult& each : medians) {
    if (each.carried_out) run[each.problem] = true;
  }
  return run;
}

std::vector<Profile> profiles(const BenchPlan& plan, const std::vector<MedianResult>& medians,
                              std::size_t which) {
  std::vector<std::vector<double>> seconds(plan.problems.size(),
                                           std::vector<double>(plan.variants.size(), infinity));
  for (const MedianResult& each : medians) {
    seconds[each.problem][each.variant] = each.seconds_to[which];
  }
  const std::vector<bool> run = problems_run(plan, medians);
  for (std::size_t p = run.size(); p-- > 0;) {
    if (!run[p]) seconds.erase(seconds.begin() + static_cast<std::ptrdiff_t>(p));
  }
  if (seconds.empty()) return std::vector<Profile>(plan.variants.size(), Profile{{1}, {0}});
  return profiles(seconds);
}

}  // namespace raybundle::tools
