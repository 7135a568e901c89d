#pragma once

#include <raybundle/linalg/parallel.h>
#include <raybundle/linalg/symmetric_blocks.h>

namespace raybundle::linalg {

/// Sparsity of the reduced matrix after the elimination of a side: blocks of the other side are
/// neighbours where they share an eliminated block. Throws MemoryRefusal when not even the least of
/// storages could hold the matrix.
SymmetricPattern reduced_pattern(const BlockLayout& layout, Side eliminated, ThreadPool& pool);

}  // namespace raybundle::linalg
