#include <raybundle/solver/linear_work.h>

namespace raybundle {

using linalg::index;

// Measured with one thread of an AMD EPYC with AVX-512 where a dense factorisation does 20
// multiplications with addition in a nanosecond (docs/decisions.md).
LinearWork linear_work(const linalg::BlockLayout& layout) {
  constexpr double per_nanosecond = 20;
  constexpr double row_nanoseconds = 10;       // of a product
  constexpr double prepared_nanoseconds = 35;  // of a row: elimination and preconditioner
  constexpr double pair_nanoseconds = 25;      // of the products of two rows of a leaf
  constexpr double coarse_nanoseconds = 130;   // of a row: matrix and factor
  const double width = static_cast<double>(layout.hub_size) / 9;
  const auto rows = static_cast<double>(layout.rows);
  double pairs = 0;
  for (std::int64_t l = 0; l < layout.leaves; ++l) {
    const auto& begin = layout.leaf_side.begin;
    const auto track = static_cast<double>(begin[index(l + 1)] - begin[index(l)]);
    pairs += track * (track + 1) / 2;
  }
  return {.product = per_nanosecond * row_nanoseconds * width * rows,
          .preparation = per_nanosecond * prepared_nanoseconds * width * width * rows,
          .assembly = per_nanosecond * pair_nanoseconds * width * width * pairs,
          .coarse = per_nanosecond * coarse_nanoseconds * width * width * rows};
}

}  // namespace raybundle
