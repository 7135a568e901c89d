#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <raybundle/tools/record.h>

/// Results for people.
namespace raybundle::tools {

/// Lines "  label   value", the values aligned. An empty label continues the line above; an empty
/// value makes the label a heading.
class Table {
 public:
  void add(std::string label, std::string value) {
    rows_.emplace_back(std::move(label), std::move(value));
  }
  void heading(std::string text) { add(std::move(text), ""); }
  std::string text() const;

 private:
  std::vector<std::pair<std::string, std::string>> rows_;
};

/// printf into a string.
[[gnu::format(printf, 1, 2)]] std::string format(const char* form, ...);

std::string bytes_text(double bytes);  ///< "53.2 MB", in powers of ten
std::string exact_text(double value);  ///< the shortest decimals that read back to `value`
std::string percent_text(std::int64_t part, std::int64_t whole);  ///< "3.1 %"

double degrees(double radians);

std::string count_text(std::int64_t count, const std::string& noun);  ///< "1 run", "2 runs"

/// What a solve achieved and what it took.
std::string solve_report(const SolveRecord& record);

}  // namespace raybundle::tools
