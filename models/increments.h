#pragma once

namespace raybundle {

/// Increments of the parameters that change pixels alike, one per kind: the best finite-difference
/// steps of [Qu18, 3.1.4, Eq. 3.38], whose printed vector is damaged. The defaults are what
/// search_increments() finds on a street-level data set (docs/increments.md).
struct Increments {
  double rotation = 1e-8;     ///< radians
  double translation = 1e-6;  ///< the world's unit of length
  double focal = 1e-4;        ///< pixels
  double k1 = 1e-7;
  double k2 = 1e-7;
  double point = 1e-6;  ///< the world's unit of length
};

}  // namespace raybundle
