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
  /// `previous_cost`: of the state before the iteration.
  static std::string row(const IterationRecord& record, double previous_cost);

 private:
  double cost_ = 0;
};

}  // namespace raybundle::tools
