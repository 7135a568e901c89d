#include <raybundle/linalg/spectrum.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace raybundle::linalg {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, 12, 12>;
using Eigen::VectorXd;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

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
    if (damping != nullptr) A(i, i) += damping[kept[index(i)]];
  }
  return A;
}

constexpr BlockSpectrum of_nothing = {infinity, 0, 1};

BlockSpectrum of_block(const double* block, int size, const double* damping) {
  const Matrix A = informed(block, size, damping);
  if (A.rows() == 0) return of_nothing;
  if (!A.allFinite()) return {nan, infinity, infinity};
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(A, Eigen::EigenvaluesOnly);
  const double smallest = eigen.eigenvalues()[0];
  const double largest = eigen.eigenvalues()[A.rows() - 1];
  return {smallest, largest, smallest > 0 ? largest / smallest : infinity};
}

// A NaN stays.
BlockSpectrum both(const BlockSpectrum& a, const BlockSpectrum& b) {
  const bool unknown = std::isnan(a.smallest) || std::isnan(b.smallest);
  return {unknown ? nan : std::min(a.smallest, b.smallest), std::max(a.largest, b.largest),
          std::max(a.worst_condition, b.worst_condition)};
}

// The largest eigenvalue of a symmetric operator, by Lanczos from a vector that sets its subspace.
// All directions are kept orthogonal: they are few.
template <class Apply>
double largest_eigenvalue(VectorXd q, Apply&& apply) {
  constexpr Eigen::Index most = 100;
  constexpr double precision = 1e-10;
  Eigen::MatrixXd Q(q.size(), std::min(most, q.size()));
  VectorXd alpha(Q.cols()), beta(Q.cols());
  double value = 0;
  for (Eigen::Index k = 0; k < Q.cols(); ++k) {
    Q.col(k) = q;
    VectorXd w = apply(q);
    alpha[k] = q.dot(w);
    for (int twice = 0; twice < 2; ++twice) {
      w -= Q.leftCols(k + 1) * (Q.leftCols(k + 1).transpose() * w);
    }
    beta[k] = w.norm();
    if (!std::isfinite(beta[k])) return nan;
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
    eigen.computeFromTridiagonal(alpha.head(k + 1), beta.head(k), Eigen::EigenvaluesOnly);
    const double before = value;
    value = eigen.eigenvalues()[k];
    const bool settled = k > 3 && std::abs(value - before) <= precision * value;
    if (settled || beta[k] <= 1e-14 * value) break;
    q = w / beta[k];
  }
  return value;
}

}  // namespace

BlockSpectrum block_spectrum(const double* blocks, int size, std::int64_t count,
                             const double* damping, ThreadPool& pool) {
  std::array<BlockSpectrum, max_chunks> partial;
  const Chunks pieces = chunks(count, 64);
  pool.run(pieces.pieces, [&](std::int64_t piece) {
    BlockSpectrum all = of_nothing;
    for (std::int64_t b = pieces.begin(piece); b < pieces.end(piece); ++b) {
      const double* added = damping == nullptr ? nullptr : damping + b * size;
      all = both(all, of_block(blocks + b * size * size, size, added));
    }
    partial[index(piece)] = all;
  });
  BlockSpectrum all = of_nothing;
  for (std::int64_t i = 0; i < pieces.pieces; ++i) all = both(all, partial[index(i)]);
  return all.smallest == infinity ? BlockSpectrum() : all;
}

ReducedSpectrum::ReducedSpectrum(const BlockLayout& layout, ThreadPool& pool)
    : pool_(pool),
      system_(make_reduced_system(layout, Side::leaves, pool)),
      cholesky_(Cholesky::make(plan_cholesky(system_->pattern(), pool.threads()), pool)),
      damping_(index(layout.unknowns())),
      gradient_(index(system_->size())) {}

// Any direction but those that no row feels: products leave them at zero.
std::vector<double> ReducedSpectrum::start() const {
  std::mt19937_64 random(1);
  std::vector<double> q(gradient_.size());
  for (std::size_t i = 0; i < q.size(); ++i) {
    const double value = static_cast<double>(random() >> 11) * 0x1p-53 - 0.5;
    q[i] = damping_[i] > 0 ? 0 : value;
  }
  return q;
}

Spectrum ReducedSpectrum::measure(const Linearization& at) {
  at.normal->diagonal(0, std::numeric_limits<double>::max(), damping_.data(), pool_);
  for (double& d : damping_) d = d > 0 ? 0 : 1;
  system_->prepare(at, damping_.data());
  const std::vector<double> values = start();
  VectorXd q = Eigen::Map<const VectorXd>(values.data(), system_->size());
  if (q.isZero(0)) return {};
  q.normalize();

  Spectrum result;
  result.largest = largest_eigenvalue(q, [&](const VectorXd& x) {
    VectorXd y(x.size());
    system_->apply(x.data(), y.data());
    return y;
  });
  if (!std::isfinite(result.largest)) return {nan, nan};
  system_->assemble(cholesky_->matrix(), gradient_.data());
  if (!cholesky_->factor()) return result;
  const double of_inverse = largest_eigenvalue(q, [&](VectorXd x) {
    cholesky_->solve(x.data());
    return x;
  });
  result.smallest = of_inverse > 0 ? 1 / of_inverse : 0;
  return result;
}

}  // namespace raybundle::linalg
