#include <raybundle/linalg/condition.h>

#include <raybundle/linalg/block_layout.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <limits>

namespace raybundle::linalg {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, 12, 12>;

constexpr double infinity = std::numeric_limits<double>::infinity();

// The rows and columns of one block that carry information, with their damping.
Matrix informed(const double* block, int size, const double* damping) {
  std::array<int, 12> kept;
  int order = 0;
  for (int i = 0; i < size; ++i) {
    if (!(block[i * size + i] <= 0)) kept[index(order++)] = i;
  }
  Matrix A(order, order);
  for (int i = 0; i < order; ++i) {
    for (int j = 0; j < order; ++j) A(i, j) = block[kept[index(i)] * size + kept[index(j)]];
    A(i, i) += damping[kept[index(i)]];
  }
  return A;
}

double condition(const double* block, int size, const double* damping) {
  const Matrix A = informed(block, size, damping);
  if (A.rows() == 0) return 1;
  if (!A.allFinite()) return infinity;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(A, Eigen::EigenvaluesOnly);
  const double smallest = eigen.eigenvalues()[0];
  return smallest > 0 ? eigen.eigenvalues()[A.rows() - 1] / smallest : infinity;
}

}  // namespace

double worst_condition(const double* blocks, int size, std::int64_t count, const double* damping,
                       ThreadPool& pool) {
  std::array<double, max_chunks> partial;
  const Chunks pieces = chunks(count, 64);
  pool.run(pieces.pieces, [&](std::int64_t piece) {
    double worst = 1;
    for (std::int64_t b = pieces.begin(piece); b < pieces.end(piece); ++b) {
      worst = std::max(worst, condition(blocks + b * size * size, size, damping + b * size));
    }
    partial[index(piece)] = worst;
  });
  double worst = 1;
  for (std::int64_t i = 0; i < pieces.pieces; ++i) worst = std::max(worst, partial[index(i)]);
  return worst;
}

}  // namespace raybundle::linalg
