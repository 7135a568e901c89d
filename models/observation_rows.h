#pragma once

#include <raybundle/linalg/large_vector.h>
#include <raybundle/linalg/parallel.h>
#include <raybundle/models/problem.h>

#include <cstdint>
#include <vector>

namespace raybundle {

/// The observations of a problem in the order the solver works in: by point, then camera;
/// observations of the same pair keep their order.
struct ObservationRows {
  ObservationRows(const Problem& problem, linalg::ThreadPool& pool);

  std::int64_t count() const { return static_cast<std::int64_t>(camera.size()); }
  std::int64_t observation_of(std::int64_t row) const {
    return observation.empty() ? row : observation[static_cast<std::size_t>(row)];
  }

  linalg::LargeVector<std::int32_t> observation;  ///< per row; empty: they are in order as given
  linalg::LargeVector<std::int32_t> camera;       ///< per row
  linalg::LargeVector<std::int32_t> point;        ///< per row
  linalg::LargeVector<std::int64_t> begin;        ///< rows of point i: [i] .. [i + 1]
};

/// Whether the observations stand in that order already.
bool is_in_row_order(const Problem& problem);

/// values[k] of every observation k, `size` numbers each, in the order of rows.
linalg::LargeVector<double> in_row_order(const ObservationRows& rows,
                                         const std::vector<double>& values, std::int64_t size,
                                         linalg::ThreadPool& pool);

}  // namespace raybundle
