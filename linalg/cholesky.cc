#include <raybundle/linalg/cholesky.h>

#include <raybundle/linalg/blas_threads.h>
#include <raybundle/linalg/cpu.h>
#include <raybundle/linalg/dense_cholesky.h>
#include <raybundle/linalg/sparse_cholesky.h>

#include <utility>

namespace raybundle::linalg {
namespace {

class Dense final : public Cholesky {
 public:
  Dense(SymmetricPattern pattern, ThreadPool& pool)
      : Cholesky(std::move(pattern), Storage::dense),
        order_(matrix().pattern().order()),
        cholesky_(order_),
        pool_(pool) {}

  bool factor() override { return cholesky_.factor(matrix().values(), order_, pool_); }
  void solve(double* x) override { cholesky_.solve(matrix().values(), order_, x); }
  std::string description() const override {
    return "dense Cholesky of order " + std::to_string(order_) + " with " +
           std::string(name(instruction_set())) + " kernels";
  }

 private:
  std::int64_t order_;
  DenseCholesky cholesky_;
  ThreadPool& pool_;
};

class Sparse final : public Cholesky {
 public:
  explicit Sparse(SymmetricPattern pattern)
      : Cholesky(std::move(pattern), Storage::sparse), cholesky_(matrix().pattern()) {
    cholesky_.analyze();
  }

  bool factor() override { return cholesky_.factor(matrix()); }
  void solve(double* x) override { cholesky_.solve(x); }
  std::string description() const override {
    return "sparse Cholesky of order " + std::to_string(matrix().pattern().order()) + " by " +
           cholesky_.ordering() + " (CHOLMOD, " + blas_name() + ")";
  }

 private:
  SparseCholesky cholesky_;
};

// A sparse factorisation runs at a fraction of the speed of a dense one, and a matrix that fits
// the cache is not worth an analysis.
SymmetricBlocks::Storage choose(const SymmetricPattern& pattern) {
  using Storage = SymmetricBlocks::Storage;
  constexpr std::int64_t always_dense = 600;
  constexpr double sparse_penalty = 3;
  const std::int64_t order = pattern.order();
  if (order <= always_dense) return Storage::dense;
  const double n = static_cast<double>(order);
  const double fill = static_cast<double>(pattern.scalar_nonzeros()) / (0.5 * n * n);
  if (fill > 0.7) return Storage::dense;
  const SparseCholesky ordered(pattern);
  return n * n * n / 3 < sparse_penalty * ordered.predicted_flops() ? Storage::dense
                                                                    : Storage::sparse;
}

}  // namespace

std::unique_ptr<Cholesky> Cholesky::make(SymmetricPattern pattern, std::optional<Storage> storage,
                                         ThreadPool& pool) {
  const Storage chosen = storage ? *storage : choose(pattern);
  if (chosen == Storage::dense) return std::make_unique<Dense>(std::move(pattern), pool);
  return std::make_unique<Sparse>(std::move(pattern));
}

}  // namespace raybundle::linalg
