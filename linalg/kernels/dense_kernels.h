#pragma once

#include <cstdint>

#include <raybundle/linalg/cpu.h>

/// Kernels of the dense Cholesky factorisation, one set per instruction set.
///
/// **Packed layout.** The lower triangle is cut into horizontal strips of `strip` rows. A strip is
/// stored column by column, `strip` numbers each, up to and including its diagonal block; strips
/// follow one another. So the same storage serves as either operand of the product L L^T with
/// aligned, contiguous reads. A *tile* is a range of strips times a range of columns, both counted
/// in strips. Rows and columns from the order n up to the next multiple of `step` are those of the
/// identity; a strip's rows beyond that are never touched.
///
/// **Order of sums.** Every entry is a_ij - l_i0 l_j0 - l_i1 l_j1 - ..., subtracted one product
/// at a time in this order (fused where the processor can). The bits of the result therefore do
/// not depend on how the work is cut into tiles; they do depend on the instruction set.
namespace raybundle::linalg {

/// Rows of the widest strip and columns of the widest step, those of AVX-512: for what is predicted
/// by one layout on every machine, and for arrays that hold a strip of any set.
inline constexpr std::int64_t widest_strip = 24, widest_step = 8;

/// Columns multiplied at a time, in whole strips: `step` rows of so many stay in the first-level
/// cache.
inline constexpr std::int64_t slice_columns = 240;

/// Strips, steps or pieces of `b` that hold `a`. Not for kernels, which call no inline functions.
constexpr std::int64_t ceil_div(std::int64_t a, std::int64_t b) { return (a + b - 1) / b; }

/// Strips [begin, end).
struct StripRange {
  std::int64_t begin;
  std::int64_t end;
};

/// A packed triangle being factorised; plain data shared by all kernels.
struct PackedTriangle {
  std::int64_t order;        ///< n
  double* values;            ///< packed strips, 64-byte aligned
  double* inverse_diagonal;  ///< 1 / l_kk, filled by `factor`; length: n rounded up to `step`
  const double* threshold;   ///< the pivot of column k must exceed this; same length
};

/// Rows below a packed triangle, of the same columns: strips like those above, each `columns` long
/// (the triangle's order rounded up to `step`). Rows and columns that stand for nothing are zero.
struct PackedRows {
  std::int64_t columns;
  double* values;  ///< 64-byte aligned
};

/// The functions and the layout constants of one instruction set.
struct DenseKernels {
  InstructionSet set;
  std::int64_t strip;  ///< rows per strip
  std::int64_t step;   ///< columns that are factorised together; divides `strip`

  /// Copies a tile of the lower triangle of A (column-major, leading dimension ld) into L, with
  /// zeros above the diagonal.
  void (*pack)(const double* A, std::int64_t ld, const PackedTriangle& L, StripRange rows,
               StripRange columns);
  /// Copies a tile back, the lower triangle only.
  void (*unpack)(const PackedTriangle& L, double* A, std::int64_t ld, StripRange rows,
                 StripRange columns);
  /// tile(rows, columns) -= L(rows, k) L(columns, k)^T for the columns k in strips `inner`. Of
  /// tiles on the diagonal the lower triangle.
  void (*update)(const PackedTriangle& L, StripRange rows, StripRange columns, StripRange inner);
  /// For rows below `columns`: subtracts the products of columns from strip `from` on and divides
  /// by the transposed diagonal tile, which must be factorised: tile <- tile L_JJ^-T.
  void (*solve)(const PackedTriangle& L, StripRange rows, StripRange columns, std::int64_t from);
  /// Factorises the diagonal tile after subtracting the products of columns from strip `from` on.
  /// False when a pivot does not exceed its threshold or is not finite.
  bool (*factor)(const PackedTriangle& L, StripRange diagonal, std::int64_t from);

  /// Of the rows R below a factorised triangle L: strips `rows` of R <- R L^-T.
  void (*solve_rows)(const PackedTriangle& L, const PackedRows& R, StripRange rows);
  /// tile(rows, columns) of C -= R(rows, :) R(columns, :)^T; of tiles on the diagonal the lower
  /// triangle.
  void (*subtract_squares)(const PackedTriangle& C, const PackedRows& R, StripRange rows,
                           StripRange columns);
  /// x <- L^-1 x and then y <- -R x; y has `strips` whole strips, x those of L.
  void (*forward_rows)(const PackedTriangle& L, const PackedRows& R, std::int64_t strips, double* x,
                       double* y);
  /// x <- L^-T (x - R^T y).
  void (*backward_rows)(const PackedTriangle& L, const PackedRows& R, std::int64_t strips,
                        double* x, const double* y);

  /// For the rows of a block, `size` x n with `stride` between them: sums += A x and y = A^T own.
  void (*multiply_both_ways)(std::int64_t size, std::int64_t n, const double* A,
                             std::int64_t stride, const double* own, const double* x, double* sums,
                             double* y);

  /// b <- L^-1 b and b <- L^-T b with L (n x n) in the lower triangle of A, column-major.
  void (*forward)(std::int64_t n, const double* A, std::int64_t ld, double* b);
  void (*backward)(std::int64_t n, const double* A, std::int64_t ld, double* b);
};

/// Each null when the library was built for a processor or by a compiler without that set.
const DenseKernels* dense_kernels_baseline();
const DenseKernels* dense_kernels_avx2();
const DenseKernels* dense_kernels_avx512();

}  // namespace raybundle::linalg
