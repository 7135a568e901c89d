#pragma once

#include <raybundle/linalg/block_layout.h>

namespace raybundle {

/// What the ways to a damped step cost, in multiplications with addition as a processor does them
/// from its caches; what waits for memory counts for more than it has. A prediction from sizes
/// alone, so that what is chosen by it is the same on every machine and for any number of threads.
struct LinearWork {
  double product = 0;      ///< one implicit product of the reduced system
  double preparation = 0;  ///< of a step by conjugate gradients beside its products
  double assembly = 0;     ///< of the reduced matrix
  double coarse = 0;       ///< of the coarse space of a step by two levels
};

/// Of a layout whose leaves are eliminated.
LinearWork linear_work(const linalg::BlockLayout& layout);

}  // namespace raybundle
