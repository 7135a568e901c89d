#include <raybundle/tools/report.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>

#include <raybundle/tools/memory.h>
#include <raybundle/version.h>

namespace raybundle::tools {
namespace {

void add_result(const SolveRecord& record, Table& table) {
  const Summary& summary = record.summary;
  const Options& options = summary.options;
  const bool graduated =
      options.loss_start_scale && *options.loss_start_scale > *options.loss_scale;
  table.add("cost", format("%.6e -> %.6e", summary.initial_cost, summary.final_cost) +
                        (graduated ? ", both at the final scale of the loss" : ""));
  if (has_loss(options)) {
    table.add("loss", format("%s of each %s, scale %g px", name(*options.loss),
                             name(*options.loss_scope), *options.loss_scale));
  }
  table.add("RMSE", format("%.6g px -> %.6g px", record.before.rmse, record.after.rmse));
  if (record.robust_before && record.robust_after) {
    table.add("median residual", format("%.6g px -> %.6g px", record.robust_before->median,
                                        record.robust_after->median));
    table.add("within the scale",
              percent_text(record.robust_before->within, record.observations) + " -> " +
                  percent_text(record.robust_after->within, record.observations) +
                  " of the observations");
  }
  if (record.before.behind_camera != 0 || record.after.behind_camera != 0) {
    table.add("behind cameras", format("%lld -> %lld observations",
                                       static_cast<long long>(record.before.behind_camera),
                                       static_cast<long long>(record.after.behind_camera)));
  }
  table.add("ended", summary.message);
}

/// What each way to a step was predicted to take, in units of the one that was taken.
std::string choice_text(const Summary& summary) {
  const LinearChoice& choice = summary.linear_choice;
  const auto work = [&](const LinearCandidate& each) { return each.work_with(choice.expected); };
  double taken = 0;
  for (const LinearCandidate& each : choice.candidates) {
    if (each.linear == summary.options.linear) taken = work(each);
  }
  std::string text;
  for (const LinearCandidate& each : choice.candidates) {
    text += format("%s%s %s%.3g", text.empty() ? "" : ", ", name(each.linear),
                   each.lower_bound ? "at least " : "", work(each) / taken);
    if (!each.fits) text += " (" + bytes_text(each.memory) + " do not fit)";
  }
  return text + format(", with %d inner iterations", choice.expected.count);
}

void add_work(const SolveRecord& record, Table& table) {
  const Summary& summary = record.summary;
  const int iterations = static_cast<int>(summary.iterations.size()) - 1;
  std::string counts = format("%d (%d accepted, %d rejected)", iterations, summary.accepted,
                              iterations - summary.accepted);
  if (summary.inner_iterations > 0) {
    counts += format(", %lld inner", static_cast<long long>(summary.inner_iterations));
  }
  table.add("iterations", counts);
  table.add("method", name(summary.options.method));
  const auto& elimination = summary.options.elimination;
  table.add("eliminated", elimination ? name(*elimination) : "points or cameras, by condition");
  table.add("linear solver", summary.linear_solver);
  if (!summary.linear_choice.candidates.empty()) {
    table.add("predicted work", choice_text(summary));
  }
  if (summary.widened_at >= 0) {
    table.add("precision", "rows of the Jacobian in double from iteration " +
                               std::to_string(summary.widened_at) + " on");
  }
  table.add("threads", std::to_string(summary.threads));
}

void add_time(const SolveRecord& record, Table& table) {
  const Timing& seconds = record.summary.seconds;
  const double total = record.read_seconds + seconds.total + record.write_seconds;
  const double rest = seconds.total - seconds.setup - seconds.residual - seconds.jacobian -
                      seconds.linear - seconds.diagnosis;
  const auto add = [&](const char* phase, double value) {
    const double share = total > 0 ? 100 * value / total : 0;
    table.add(std::string("  ") + phase, format("%9.3f s  %5.1f %%", value, share));
  };
  table.add("time", format("%9.3f s", total));
  add("read", record.read_seconds);
  add("set-up", seconds.setup);
  add("residual", seconds.residual);
  add("Jacobian", seconds.jacobian);
  add("linear", seconds.linear);
  if (record.summary.options.diagnose) add("diagnosis", seconds.diagnosis);
  add("other", std::max(0.0, rest));
  add("write", record.write_seconds);
  table.add("peak memory", bytes_text(static_cast<double>(peak_memory())));
}

}  // namespace

std::string Table::text() const {
  std::size_t width = 0;
  for (const auto& [label, value] : rows_) {
    if (!value.empty()) width = std::max(width, label.size());
  }
  std::string text;
  for (const auto& [label, value] : rows_) {
    text += "  " + label;
    if (!value.empty()) text += std::string(width - label.size() + 2, ' ') + value;
    text += '\n';
  }
  return text;
}

std::string format(const char* form, ...) {
  std::va_list arguments;
  va_start(arguments, form);
  std::va_list copy;
  va_copy(copy, arguments);
  const int size = std::vsnprintf(nullptr, 0, form, copy);
  va_end(copy);
  std::string text(static_cast<std::size_t>(std::max(size, 0)), '\0');
  std::vsnprintf(text.data(), text.size() + 1, form, arguments);
  va_end(arguments);
  return text;
}

std::string bytes_text(double bytes) {
  constexpr std::array units = {"B", "kB", "MB", "GB", "TB", "PB", "EB"};
  std::size_t unit = 0;
  for (; bytes >= 1000 && unit + 1 < units.size(); ++unit) bytes /= 1000;
  return unit == 0 ? format("%.0f B", bytes) : format("%.3g %s", bytes, units[unit]);
}

std::string exact_text(double value) {
  std::array<char, 32> buffer;
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr};
}

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

std::string count_text(std::int64_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string percent_text(std::int64_t part, std::int64_t whole) {
  const double share = whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
  return format("%.1f %%", 100 * share);
}

std::string solve_report(const SolveRecord& record) {
  Table table;
  table.add("problem", record.source + ": " + std::to_string(record.cameras) + " cameras, " +
                           std::to_string(record.points) + " points, " +
                           std::to_string(record.observations) + " observations");
  add_result(record, table);
  add_work(record, table);
  add_time(record, table);
  if (!record.output.empty()) table.add("solution", record.output);
  if (!record.log.empty()) table.add("log", record.log);
  return std::string("raybundle ") + version + "\n" + table.text();
}

}  // namespace raybundle::tools
