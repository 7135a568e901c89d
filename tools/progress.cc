#include <raybundle/tools/progress.h>

#include <array>
#include <cmath>
#include <cstdio>

namespace raybundle::tools {
namespace {

/// A number, or a dash where there is none.
std::string cell(const char* format, int width, double value) {
  std::array<char, 40> buffer;
  if (std::isnan(value)) {
    std::snprintf(buffer.data(), buffer.size(), " %*s", width, "-");
  } else {
    std::snprintf(buffer.data(), buffer.size(), format, width, value);
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

void ProgressTable::show(const IterationRecord& record) {
  const bool start = record.iteration == 0;
  const std::string text = (start ? header() : std::string()) + row(record);
  std::fputs(text.c_str(), stderr);  // whoever does not listen misses it, that is all
}

}  // namespace raybundle::tools
