#pragma once

#include <string>

#include <raybundle/solver/summary.h>

namespace raybundle::tools {

/// The table of iterations on standard error: a header, then a row per iteration. Costs and
/// gradients are those of the state kept; the decrease of a rejected row is that of the trial.
/// Where the scale of the loss changed, a line says so: the rows on either side have different
/// costs of one state. What --diagnose asks for stands below a row.
class ProgressTable {
 public:
  void show(const IterationRecord& record);
  std::string next(const IterationRecord& record);  ///< what show() shows

  static std::string header();
  static std::string row(const IterationRecord& record);
  static std::string diagnosis(const Diagnosis& diagnosis);

 private:
  double loss_scale_ = 0;  // of the row before
};

}  // namespace raybundle::tools
