#include <raybundle/tools/bench_report.h>

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include <raybundle/models/io/atomic_file.h>
#include <raybundle/tools/bench_plots.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr int schema = 1;

/// The columns of one run, the same for CSV and JSON.
void visit_columns(const BenchPlan& plan, const RunResult& run, auto&& visit) {
  visit("problem", plan.problems[run.problem].name);
  visit("variant", plan.variants[run.variant].name);
  visit("run", run.run);
  visit("status", std::string(name(run.status)));
  visit("termination", run.termination);
  visit("initial_cost", run.initial_cost);
  visit("final_cost", run.final_cost);
  visit("gradient_norm", run.gradient_norm);
  visit("iterations", run.iterations);
  visit("inner_iterations", run.inner_iterations);
  visit("seconds", run.seconds);
  for (std::size_t i = 0; i < accuracies.size(); ++i) {
    const int decade = static_cast<int>(std::lround(-std::log10(accuracies[i])));
    visit(format("seconds_to_1e-%d", decade).c_str(), run.seconds_to[i]);
  }
  visit("peak_bytes", run.peak_bytes);
  visit("camera_rmse", run.camera_rmse);
  visit("point_rmse", run.point_rmse);
  visit("message", run.message);
}

std::string csv_text(double value) { return std::isnan(value) ? "" : exact_text(value); }
std::string csv_text(std::int64_t value) { return value < 0 ? "" : std::to_string(value); }
std::string csv_text(int value) { return csv_text(std::int64_t{value}); }
std::string csv_text(const std::string& value) {
  if (value.find_first_of(",\"\r\n") == std::string::npos) return value;
  std::string text = "\"";
  for (const char c : value) {
    if (c == '"') text += '"';
    text += c;
  }
  return text + "\"";
}

Json json_value(const std::string& value) { return value; }
Json json_value(double value) { return std::isfinite(value) ? Json(value) : Json(); }
Json json_value(std::int64_t value) { return value < 0 ? Json() : Json(value); }
Json json_value(int value) { return json_value(std::int64_t{value}); }

/// A number of a table: three digits, empty for none.
std::string cell(double value, const char* form = "%.3g") {
  if (std::isnan(value)) return "";
  if (std::isinf(value)) return "never";
  return format(form, value);
}

/// "Start 12, best 3.", or why they are not known.
std::string costs_text(const BenchResults& results, std::size_t problem) {
  const double start = results.start[problem], best = results.best[problem];
  const std::string text = std::isnan(start) ? "No run has a cost" : "Start " + cell(start, "%.8g");
  return text + (std::isinf(best) ? "" : ", best " + cell(best, "%.10g")) + ".";
}

std::string problem_table(const BenchPlan& plan, const BenchResults& results,
                          const std::vector<MedianResult>& medians, std::size_t problem) {
  const std::string title = "### " + plan.problems[problem].name + "\n\n";
  const bool has_runs = std::any_of(medians.begin(), medians.end(), [&](const MedianResult& each) {
    return each.problem == problem;
  });
  if (!has_runs) return title + "Not run.\n\n";
  std::string text =
      title + costs_text(results, problem) +
      "\n\n"
      "| variant | status | final cost | over best | gradient | iterations | inner | "
      "s | s to 1e-1 | s to 1e-2 | s to 1e-3 | s to 1e-5 | peak MB | camera RMSE | point RMSE |\n"
      "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
  for (const MedianResult& each : medians) {
    if (each.problem != problem) continue;
    text += "| " + plan.variants[each.variant].name + " | " + each.status + " | " +
            cell(each.final_cost, "%.8g") + " | " +
            (each.compared ? cell(each.final_cost / results.best[problem], "%.6f") : "-") + " | " +
            cell(each.gradient_norm) + " | " + cell(each.iterations, "%.0f") + " | " +
            cell(each.inner_iterations, "%.0f") + " | " + cell(each.seconds);
    for (const double seconds : each.seconds_to) text += " | " + cell(seconds);
    text += " | " + cell(each.peak_bytes / 1e6, "%.0f") + " | " + cell(each.camera_rmse) + " | " +
            cell(each.point_rmse) + " |\n";
  }
  return text + "\n";
}

std::string profile_table(const BenchPlan& plan, const std::vector<MedianResult>& medians,
                          std::size_t which) {
  constexpr std::array<double, 5> ratios = {1, 1.5, 2, 5, INFINITY};
  std::string text = format("| tau = %.0e |", accuracies[which]), line = "|---|";
  for (const double ratio : ratios) {
    text += std::isinf(ratio) ? " ever |" : format(" %gx |", ratio);
    line += "--:|";
  }
  text += "\n" + line + "\n";
  const std::vector<Profile> all = profiles(plan, medians, which);
  for (std::size_t v = 0; v < plan.variants.size(); ++v) {
    text += "| " + plan.variants[v].name + " |";
    for (const double ratio : ratios) text += format(" %.0f %% |", 100 * share_at(all[v], ratio));
    text += "\n";
  }
  const std::string plot = format("plots/profile_%.0e.svg", accuracies[which]);
  if (std::filesystem::exists(plan.folder / plot)) text += "\n![Profile](" + plot + ")\n";
  return text + "\n";
}

/// What the shares of the profiles are shares of.
std::string denominator_text(const BenchPlan& plan, const std::vector<MedianResult>& medians) {
  const std::vector<bool> run = problems_run(plan, medians);
  const auto count = std::count(run.begin(), run.end(), true);
  if (count == 0) return "No problem was run.\n\n";
  const auto carried_out =
      std::count_if(medians.begin(), medians.end(), [](const auto& m) { return m.carried_out; });
  const auto missing = count * static_cast<std::ptrdiff_t>(plan.variants.size()) - carried_out;
  std::string text = std::to_string(count) + " of " +
                     count_text(static_cast<std::int64_t>(run.size()), "problem") +
                     (count == 1 ? " was" : " were") + " run: the shares are of those.\n";
  if (missing > 0) {
    text += count_text(missing, "pair") +
            " of variant and problem among them, refused or not run yet, count as not solved.\n";
  }
  return text + "\n";
}

Json profiles_json(const BenchPlan& plan, const std::vector<MedianResult>& medians) {
  Json all = Json::array();
  for (std::size_t i = 0; i < accuracies.size(); ++i) {
    const std::vector<Profile> curves = profiles(plan, medians, i);
    for (std::size_t v = 0; v < curves.size(); ++v) {
      all.push_back({{"tau", accuracies[i]},
                     {"variant", plan.variants[v].name},
                     {"ratio", curves[v].ratio},
                     {"share", curves[v].share}});
    }
  }
  return all;
}

/// Of the call that ran last; of this one where none did.
Machine machine_of(const BenchPlan& plan) {
  const auto file = plan.folder / "machine.json";
  if (!std::filesystem::exists(file)) return this_machine();
  return machine_from_json(file_text(file), file.string());
}

}  // namespace

std::string results_csv(const BenchPlan& plan, const BenchResults& results) {
  std::string header, lines;
  visit_columns(plan, RunResult{}, [&](const char* name, const auto&) {
    header += (header.empty() ? "" : ",") + std::string(name);
  });
  for (const RunResult& run : results.runs) {
    std::string line;
    visit_columns(plan, run, [&](const char* name, const auto& value) {
      line += (std::string_view(name) == "problem" ? "" : ",") + csv_text(value);
    });
    lines += line + "\n";
  }
  return header + "\n" + lines;
}

std::string results_json(const BenchPlan& plan, const BenchResults& results,
                         const Machine& machine) {
  Json problems = Json::array(), variants = Json::array(), runs = Json::array();
  for (std::size_t p = 0; p < plan.problems.size(); ++p) {
    problems.push_back({{"name", plan.problems[p].name},
                        {"file", plan.problems[p].file.string()},
                        {"generate", plan.problems[p].generate},
                        {"start", json_value(results.start[p])},
                        {"best", json_value(results.best[p])}});
  }
  for (const BenchVariant& variant : plan.variants) {
    variants.push_back({{"name", variant.name},
                        {"solver", variant.solver == BenchSolver::ceres ? "ceres" : "raybundle"},
                        {"options", variant.options}});
  }
  for (const RunResult& run : results.runs) {
    Json json = Json::object();
    visit_columns(plan, run,
                  [&](const char* name, const auto& value) { json[name] = json_value(value); });
    runs.push_back(std::move(json));
  }
  const Json json = {{"schema", schema},
                     {"machine", Json::parse(to_json(machine))},
                     {"arguments", Json::parse(to_json(plan.arguments))},
                     {"problems", std::move(problems)},
                     {"variants", std::move(variants)},
                     {"runs", std::move(runs)},
                     {"profiles", profiles_json(plan, medians(plan, results))}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string summary_markdown(const BenchPlan& plan, const BenchResults& results,
                             const Machine& machine) {
  const std::vector<MedianResult> all = medians(plan, results);
  std::string text = "# Bench\n\n" + machine.processor + ", " + count_text(machine.cores, "core") +
                     ", " + bytes_text(static_cast<double>(machine.memory)) + ", kernels " +
                     machine.instruction_set + ", " + machine.system + ".\nraybundle " +
                     machine.version + " (" + machine.build + "). " + "Medians of " +
                     count_text(plan.arguments.runs, "run") + "; " +
                     count_text(plan.arguments.threads, "thread") + "; time limit " +
                     format("%g", plan.arguments.time_limit) + " s.\n\n";
  for (const BenchVariant& variant : plan.variants) {
    text += "- `" + variant.name + "`:";
    for (const std::string& word : variant.options) text += " " + word;
    text += "\n";
  }
  text +=
      "\n## Profiles\n\nShare of the problems that a variant solves to within tau of the best "
      "(cost at "
      "most best + tau (start - best))\nin at most so many times the time of the fastest "
      "variant. " +
      denominator_text(plan, all);
  for (std::size_t i = 0; i < accuracies.size(); ++i) text += profile_table(plan, all, i);
  text +=
      "## Problems\n\nTimes count from the start of the solve. Errors against the truth, where it "
      "is "
      "known, are RMSE.\n\n";
  for (std::size_t p = 0; p < plan.problems.size(); ++p) {
    text += problem_table(plan, results, all, p);
  }
  return text;
}

std::string write_reports(const BenchPlan& plan) {
  const BenchResults results = read_results(plan);
  const Machine machine = machine_of(plan);
  io::write_file_atomically(plan.folder / "results.csv", results_csv(plan, results));
  io::write_file_atomically(plan.folder / "results.json", results_json(plan, results, machine));
  std::string complaint = write_plots(plan, results);
  io::write_file_atomically(plan.folder / "summary.md", summary_markdown(plan, results, machine));
  return complaint;
}

}  // namespace raybundle::tools
