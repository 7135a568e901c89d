#include <raybundle/linalg/symmetric_product.h>

#include <raybundle/linalg/tiled_cholesky.h>

#include <algorithm>

namespace raybundle::linalg {
namespace {

// Parts are few beside the numbers of the matrix.
std::int64_t piece_count(const SymmetricPattern& pattern) {
  constexpr std::int64_t numbers_of_part = 16, most = 32;
  return std::clamp<std::int64_t>(
      pattern.scalar_nonzeros() / (numbers_of_part * pattern.order() + 1), 1, most);
}

}  // namespace

SymmetricProduct::SymmetricProduct(const SymmetricPattern& pattern, InstructionSet set)
    : pattern_(pattern), kernels_(dense_kernels(set)) {
  const double share =
      static_cast<double>(pattern.scalar_nonzeros()) / static_cast<double>(piece_count(pattern));
  double numbers = 0;
  std::int64_t size = 0;
  for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
    if (numbers >= share * static_cast<double>(pieces_.size())) {
      pieces_.push_back({a, a, pattern.offset[index(a)], nullptr});
      size += pattern.order() - pattern.offset[index(a)];
    }
    pieces_.back().last = a + 1;
    std::int64_t length = 0;
    for (std::int64_t p = pattern.row_begin[index(a)]; p < pattern.row_begin[index(a + 1)]; ++p) {
      length += pattern.block_size(pattern.column[index(p)]);
    }
    longest_ = std::max(longest_, length);
    numbers += static_cast<double>(pattern.block_size(a) * length);
  }
  parts_.resize(index(size));
  scratch_.resize(pieces_.size() * 2 * index(longest_));
  double* next = parts_.data();
  for (Piece& piece : pieces_) {
    piece.part = next;
    next += pattern.order() - piece.begin;
  }
}

double SymmetricProduct::memory(const SymmetricPattern& pattern) {
  return 8.0 * static_cast<double>(piece_count(pattern) + 2) * static_cast<double>(pattern.order());
}

void SymmetricProduct::multiply(const SymmetricBlocks& A, const double* x, double* y,
                                ThreadPool& pool) {
  const auto count = static_cast<std::int64_t>(pieces_.size());
  pool.run(count, [&](std::int64_t piece) { multiply_piece(A, x, piece); });
  parallel_for(pool, pattern_.order(), 1024, [&](std::int64_t first, std::int64_t last) {
    std::fill(y + first, y + last, 0.0);
    for (const Piece& piece : pieces_) {
      for (std::int64_t i = std::max(first, piece.begin); i < last; ++i) {
        y[i] += piece.part[i - piece.begin];
      }
    }
  });
}

// The diagonal block, which comes first and is stored whole, belongs to the rows alone.
void SymmetricProduct::multiply_piece(const SymmetricBlocks& A, const double* x, std::int64_t at) {
  const Piece& piece = pieces_[index(at)];
  double* const sums = piece.part - piece.begin;
  std::fill_n(piece.part, pattern_.order() - piece.begin, 0.0);
  double* const gathered = scratch_.data() + at * 2 * longest_;
  double* const products = gathered + longest_;
  for (std::int64_t a = piece.first; a < piece.last; ++a) {
    const std::int64_t own = pattern_.offset[index(a)], size = pattern_.block_size(a);
    const std::int64_t first = pattern_.row_begin[index(a)] + 1;
    const std::int64_t last = pattern_.row_begin[index(a + 1)];
    const double* const values = A.row(a);
    const std::int64_t stride = A.stride(a);
    for (std::int64_t i = 0; i < size; ++i) {
      for (std::int64_t j = i; j < size; ++j) {
        sums[own + i] += values[i * stride + j] * x[own + j];
        if (j > i) sums[own + j] += values[i * stride + j] * x[own + i];
      }
    }
    const auto for_blocks = [&](auto&& visit) {
      std::int64_t shift = 0;
      for (std::int64_t p = first; p < last; ++p) {
        const std::int64_t b = pattern_.column[index(p)], begin = pattern_.offset[index(b)];
        for (std::int64_t i = begin; i < pattern_.offset[index(b + 1)]; ++i) visit(i, shift++);
      }
    };
    for_blocks([&](std::int64_t i, std::int64_t k) { gathered[k] = x[i]; });
    kernels_.multiply_both_ways(size, stride - size, values + size, stride, x + own, gathered,
                                sums + own, products);
    for_blocks([&](std::int64_t i, std::int64_t k) { sums[i] += products[k]; });
  }
}

}  // namespace raybundle::linalg
