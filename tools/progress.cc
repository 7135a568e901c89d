#include <raybundle/tools/progress.h>

#include <array>
#include <cmath>
#include <cstdio>

#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

/// A number, or a dash where there is none.
std::string cell(const char* form, int width, double value) {
  std::array<char, 40> buffer;
  if (std::isnan(value)) {
    std::snprintf(buffer.data(), buffer.size(), " %*s", width, "-");
  } else {
    std::snprintf(buffer.data(), buffer.size(), form, width, value);
  }
  return buffer.data();
}

}  // namespace

std::string ProgressTable::header() {
  std::array<char, 160> buffer;
  std::snprintf(buffer.data(), buffer.size(), "%5s %13s %10s %10s %10s %9s %9s %9s %6s %9s\n",
                "iter", "cost", "decrease", "|gradient|", "|step|", "rho", "damping", "radius",
                "inner", "seconds");
  return buffer.data();
}

std::string ProgressTable::row(const IterationRecord& record) {
  const bool start = record.iteration == 0;
  const double none = std::nan("");
  std::string text = cell("%*.0f", 5, record.iteration);
  text += cell(" %*.6e", 13, record.cost);
  text += cell(" %*.2e", 10, start ? none : record.rho * record.predicted_decrease);
  text += cell(" %*.2e", 10, record.gradient_norm);
  text += cell(" %*.2e", 10, start ? none : record.step_norm);
  text += cell(" %*.2e", 9, start ? none : record.rho);
  text += cell(" %*.1e", 9, start || record.damping == 0 ? none : record.damping);
  text += cell(" %*.1e", 9, start || record.radius == 0 ? none : record.radius);
  text += cell(" %*.0f", 6, start ? none : record.inner_iterations);
  text += cell(" %*.3f", 9, record.seconds);
  return text + (record.accepted ? "\n" : "  rejected\n");
}

std::string ProgressTable::diagnosis(const Diagnosis& d) {
  return format("      eigenvalues: points %.3g .. %.3g, worst condition %.3g; ", d.points_smallest,
                d.points_largest, d.points_worst_condition) +
         format("reduced system %.3g .. %.3g\n", d.reduced_smallest, d.reduced_largest);
}

std::string ProgressTable::next(const IterationRecord& record) {
  std::string text = row(record);
  if (record.iteration == 0) {
    text = header() + text;
  } else if (record.loss_scale != loss_scale_) {
    // Of the state before this row, to which its decrease belongs.
    const double decrease = record.accepted ? record.rho * record.predicted_decrease : 0;
    text = format("      loss scale %.4g -> %.4g px: the cost so far becomes %.6e\n", loss_scale_,
                  record.loss_scale, record.cost + decrease) +
           text;
  }
  if (record.diagnosis) text += diagnosis(*record.diagnosis);
  loss_scale_ = record.loss_scale;
  return text;
}

void ProgressTable::show(const IterationRecord& record) {
  const std::string text = next(record);
  std::fputs(text.c_str(), stderr);  // whoever does not listen misses it, that is all
}

}  // namespace raybundle::tools
