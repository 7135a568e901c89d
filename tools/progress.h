#pragma once

#include <string>

#include <raybundle/solver/summary.h>

namespace raybundle::tools {

/// The table of iterations on standard error: a header, then a row per iteration. Costs and
/// gradients are those of the state kept; the decrease of a rejected row is that of the trial.
class ProgressTable {
 public:
  void show(const IterationRecord& record);

  static std::string header();
  static std::string row(const IterationRecord& record);
};

}  // namespace raybundle::tools
