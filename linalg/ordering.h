#pragma once

#include <raybundle/linalg/symmetric_blocks.h>

#include <string>
#include <vector>

namespace raybundle::linalg {

/// In which order to factorise the blocks of a symmetric matrix, and what that will cost.
struct Ordering {
  std::string method;                     ///< "minimum degree" or "nested dissection"
  std::vector<std::int64_t> permutation;  ///< blocks in the order of elimination
  double nonzeros = 0;                    ///< numbers in the factor, predicted
  double flops = 0;                       ///< of one factorisation, predicted
};

/// Orders the graph of blocks by minimum degree (AMD) and by nested dissection (METIS), and keeps
/// the one with less predicted fill. Throws std::bad_alloc.
Ordering find_ordering(const SymmetricPattern& pattern);

}  // namespace raybundle::linalg
