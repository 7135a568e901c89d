#include <raybundle/linalg/cholesky.h>

#include <raybundle/linalg/blas_threads.h>
#include <raybundle/linalg/cpu.h>
#include <raybundle/linalg/dense_cholesky.h>
#include <raybundle/linalg/memory.h>
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
  Sparse(SymmetricPattern pattern, const Ordering& ordering)
      : Cholesky(std::move(pattern), Storage::sparse),
        method_(ordering.method),
        cholesky_(matrix().pattern(), ordering) {}

  bool factor() override { return cholesky_.factor(matrix()); }
  void solve(double* x) override { cholesky_.solve(x); }
  std::string description() const override {
    return "sparse Cholesky of order " + std::to_string(matrix().pattern().order()) + " by " +
           method_ + " (CHOLMOD, " + blas_name() + ")";
  }

 private:
  std::string method_;
  SparseCholesky cholesky_;
};

double square(std::int64_t order) {
  return static_cast<double>(order) * static_cast<double>(order);
}

// Whether dense storage can win: a matrix that fits the cache is not worth an analysis, and a
// nearly full one has no sparsity to use.
bool obviously_dense(const SymmetricPattern& pattern) {
  constexpr std::int64_t always_dense = 600;
  constexpr double full = 0.7;
  return pattern.order() <= always_dense ||
         static_cast<double>(pattern.scalar_nonzeros()) > full * 0.5 * square(pattern.order());
}

// A sparse factorisation runs at a fraction of the speed of a dense one.
bool dense_is_faster(const SymmetricPattern& pattern, const Ordering& ordering) {
  constexpr double sparse_penalty = 3;
  return square(pattern.order()) * static_cast<double>(pattern.order()) / 3 <
         sparse_penalty * ordering.flops;
}

void require_dense_memory(const SymmetricPattern& pattern) {
  require_memory(DenseCholesky::memory(pattern.order()),
                 "a dense matrix of order " + std::to_string(pattern.order()));
}

void require_sparse_memory(const SymmetricPattern& pattern, const Ordering& ordering) {
  require_memory(SparseCholesky::memory(pattern, ordering),
                 "a sparse factorisation of order " + std::to_string(pattern.order()));
}

}  // namespace

std::unique_ptr<Cholesky> Cholesky::make(SymmetricPattern pattern, std::optional<Storage> storage,
                                         ThreadPool& pool) {
  bool dense = storage ? *storage == Storage::dense : obviously_dense(pattern);
  if (!dense) {
    const Ordering ordering = find_ordering(pattern);
    dense = !storage && dense_is_faster(pattern, ordering);
    if (!dense) {
      require_sparse_memory(pattern, ordering);
      return std::make_unique<Sparse>(std::move(pattern), ordering);
    }
  }
  require_dense_memory(pattern);
  return std::make_unique<Dense>(std::move(pattern), pool);
}

}  // namespace raybundle::linalg
