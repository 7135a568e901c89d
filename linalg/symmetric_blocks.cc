#include <raybundle/linalg/symmetric_blocks.h>

#include <algorithm>
#include <utility>

namespace raybundle::linalg {
namespace {

// Scalars in one scalar row of block row a.
std::int64_t row_length(const SymmetricPattern& pattern, std::int64_t a) {
  std::int64_t length = 0;
  for (std::int64_t p = pattern.row_begin[index(a)]; p < pattern.row_begin[index(a + 1)]; ++p) {
    length += pattern.block_size(pattern.column[index(p)]);
  }
  return length;
}

}  // namespace

std::int64_t SymmetricPattern::scalar_nonzeros() const {
  std::int64_t sum = 0;
  for (std::int64_t a = 0; a < blocks(); ++a) sum += block_size(a) * row_length(*this, a);
  return sum;
}

SymmetricBlocks::SymmetricBlocks(SymmetricPattern pattern, Storage storage)
    : pattern_(std::move(pattern)), storage_(storage) {
  const std::int64_t order = pattern_.order();
  const bool dense = storage_ == Storage::dense;
  row_value_.resize(index(pattern_.blocks() + 1));
  shift_.resize(pattern_.column.size());
  std::int64_t next = 0;
  for (std::int64_t a = 0; a < pattern_.blocks(); ++a) {
    const std::int64_t begin = pattern_.offset[index(a)];
    row_value_[index(a)] = dense ? begin * order + begin : next;
    std::int64_t shift = 0;
    for (std::int64_t p = pattern_.row_begin[index(a)]; p < pattern_.row_begin[index(a + 1)]; ++p) {
      const std::int64_t b = pattern_.column[index(p)];
      shift_[index(p)] = dense ? pattern_.offset[index(b)] - begin : shift;
      shift += pattern_.block_size(b);
    }
    next += pattern_.block_size(a) * shift;
  }
  row_value_.back() = dense ? order * order : next;
  values_.assign(index(row_value_.back()), 0.0);
}

std::int64_t SymmetricBlocks::stride(std::int64_t a) const {
  if (storage_ == Storage::dense) return pattern_.order();
  return (row_value_[index(a + 1)] - row_value_[index(a)]) / pattern_.block_size(a);
}

void SymmetricBlocks::set_zero(std::int64_t a) {
  // In dense storage the whole row right of the diagonal: factorising fills what was zero.
  const std::int64_t length =
      storage_ == Storage::dense ? pattern_.order() - pattern_.offset[index(a)] : stride(a);
  for (std::int64_t i = 0; i < pattern_.block_size(a); ++i) {
    std::fill_n(row(a) + i * stride(a), length, 0.0);
  }
}

}  // namespace raybundle::linalg
