#pragma once

#include <raybundle/linalg/parallel.h>
#include <raybundle/linalg/symmetric_blocks.h>

#include <cstdint>

namespace raybundle::linalg {

/// Sparsity of the reduced matrix after the elimination of a side: blocks of the other side are
/// neighbours where they share an eliminated block. Throws MemoryRefusal where the matrix alone
/// would take more than is available.
SymmetricPattern reduced_pattern(const BlockLayout& layout, Side eliminated, ThreadPool& pool);

/// How many blocks the upper triangle of that matrix has; takes next to no memory.
std::int64_t count_reduced_blocks(const BlockLayout& layout, Side eliminated, ThreadPool& pool);

/// About as many, in a sixteenth of the time: counted for every 16th block of the diagonal.
double sampled_reduced_blocks(const BlockLayout& layout, Side eliminated, ThreadPool& pool);

/// As many where they may be a lot, else no fewer: for who wants to know soon whether they fit.
double most_reduced_blocks(const BlockLayout& layout, Side eliminated, ThreadPool& pool);

}  // namespace raybundle::linalg
