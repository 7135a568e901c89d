#include <raybundle/solver/init/pose_graph_system.h>

#include <algorithm>

namespace raybundle::init {
namespace {

using linalg::index;

linalg::SymmetricPattern pattern_of(std::int64_t images, std::int64_t size,
                                    std::vector<std::pair<std::int32_t, std::int32_t>> couples) {
  for (auto& [a, b] : couples) {
    if (a > b) std::swap(a, b);
  }
  for (std::int32_t i = 0; i < images; ++i) couples.emplace_back(i, i);
  std::sort(couples.begin(), couples.end());
  couples.erase(std::unique(couples.begin(), couples.end()), couples.end());
  linalg::SymmetricPattern pattern;
  pattern.row_begin.push_back(0);
  pattern.offset.push_back(0);
  pattern.column.reserve(couples.size());
  for (const auto& [a, b] : couples) pattern.column.push_back(b);
  auto at = couples.begin();
  for (std::int32_t i = 0; i < images; ++i) {
    at = std::find_if(at, couples.end(), [&](const auto& couple) { return couple.first != i; });
    pattern.row_begin.push_back(at - couples.begin());
    pattern.offset.push_back(size * (std::int64_t{i} + 1));
  }
  return pattern;
}

}  // namespace

template <int size>
PoseGraphSystem<size>::PoseGraphSystem(std::int64_t images, std::vector<Couple> couples,
                                       linalg::ThreadPool& pool)
    : cholesky_(linalg::Cholesky::make(
          linalg::plan_cholesky(pattern_of(images, size, std::move(couples)), pool.threads()),
          pool)) {}

template <int size>
void PoseGraphSystem<size>::set_zero() {
  linalg::SymmetricBlocks& A = cholesky_->matrix();
  for (std::int64_t i = 0; i < A.pattern().blocks(); ++i) A.set_zero(i);
}

template <int size>
void PoseGraphSystem<size>::keep() {
  const linalg::SymmetricBlocks& A = cholesky_->matrix();
  kept_.assign(A.values(), A.values() + A.value_count());
}

template <int size>
void PoseGraphSystem<size>::restore() {
  std::copy(kept_.begin(), kept_.end(), cholesky_->matrix().values());
}

// a <= b.
template <int size>
double* PoseGraphSystem<size>::block_at(std::int32_t a, std::int32_t b) {
  linalg::SymmetricBlocks& A = cholesky_->matrix();
  const linalg::SymmetricPattern& pattern = A.pattern();
  const auto first = pattern.column.begin() + pattern.row_begin[index(a)];
  const auto last = pattern.column.begin() + pattern.row_begin[index(a + 1)];
  const auto found = std::lower_bound(first, last, b);
  return A.row(a) + A.block_shift(found - pattern.column.begin());
}

template <int size>
void PoseGraphSystem<size>::add(std::int32_t a, std::int32_t b, const Block& block) {
  const bool upper = a <= b;
  double* at = upper ? block_at(a, b) : block_at(b, a);
  const std::int64_t next = stride(std::min(a, b));
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) at[r * next + c] += upper ? block(r, c) : block(c, r);
  }
}

template <int size>
void PoseGraphSystem<size>::hold(std::int32_t image) {
  const linalg::SymmetricPattern& pattern = cholesky_->matrix().pattern();
  const auto set = [&](std::int32_t a, std::int32_t b) {
    double* at = block_at(a, b);
    for (int r = 0; r < size; ++r) {
      for (int c = 0; c < size; ++c) at[r * stride(a) + c] = a == b && r == c ? 1 : 0;
    }
  };
  for (std::int32_t a = 0; a <= image; ++a) {
    const auto first = pattern.column.begin() + pattern.row_begin[index(a)];
    const auto last = pattern.column.begin() + pattern.row_begin[index(a + 1)];
    if (a < image && std::binary_search(first, last, image)) set(a, image);
    if (a < image) continue;
    for (auto b = first; b != last; ++b) set(a, *b);
  }
}

template <int size>
void PoseGraphSystem<size>::solve(Eigen::Ref<Eigen::MatrixXd> x) {
  Eigen::VectorXd column;
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    column = x.col(k);
    cholesky_->solve(column.data());
    x.col(k) = column;
  }
}

template class PoseGraphSystem<1>;
template class PoseGraphSystem<3>;

}  // namespace raybundle::init
