#pragma once

#include <raybundle/models/problem.h>

#include <cstdint>
#include <vector>

namespace raybundle {

/// The observations of a problem in the order the solver works in: by point, then camera;
/// observations of the same pair keep their order.
struct ObservationRows {
  explicit ObservationRows(const Problem& problem);

  std::int64_t count() const { return static_cast<std::int64_t>(camera.size()); }

  std::vector<std::int64_t> observation;  ///< per row
  std::vector<std::int32_t> camera;       ///< per row
  std::vector<std::int32_t> point;        ///< per row
  std::vector<std::int64_t> begin;        ///< rows of point i: [i] .. [i + 1]
};

/// values[k] of every observation k, `size` numbers each, in the order of rows.
std::vector<double> in_row_order(const ObservationRows& rows, const std::vector<double>& values,
                                 std::int64_t size);

}  // namespace raybundle
