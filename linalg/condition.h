#pragma once

#include <raybundle/linalg/parallel.h>

#include <cstdint>

namespace raybundle::linalg {

/// The condition number of a block-diagonal matrix plus a diagonal: its largest over its smallest
/// eigenvalue, both of all blocks together and exact, since the eigenvalues of the whole are those of
/// its blocks. `blocks`: count x (size x size), symmetric positive semi-definite, size at most 12;
/// `damping`: count x size. Unknowns without information (a zero on the diagonal of their block) are
/// left out, as they are never moved. Infinite where the smallest eigenvalue is not positive; 1 where
/// there is nothing to count.
double condition_number(const double* blocks, int size, std::int64_t count, const double* damping,
                        ThreadPool& pool);

}  // namespace raybundle::linalg
