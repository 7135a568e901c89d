#pragma once

#include <raybundle/linalg/parallel.h>

#include <cstdint>

namespace raybundle::linalg {

/// The largest condition number of a block of a block-diagonal matrix plus a diagonal, from the
/// blocks' eigenvalues: what bounds the accuracy of inverting it, which is done block by block.
/// `blocks`: count x (size x size), symmetric positive semi-definite, size at most 12; `damping`:
/// count x size. Unknowns without information (a zero on the diagonal of their block) are left out,
/// as they are never moved. Infinite where a block is not positive definite; 1 where there is
/// nothing to count.
double worst_condition(const double* blocks, int size, std::int64_t count, const double* damping,
                       ThreadPool& pool);

}  // namespace raybundle::linalg
