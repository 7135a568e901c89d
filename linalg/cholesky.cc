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

double dense_work(const SymmetricPattern& pattern) {
  return square(pattern.order()) * static_cast<double>(pattern.order()) / 6;
}

// A sparse factorisation runs at a fraction of the speed of a dense one.
double sparse_work(const Ordering& ordering) {
  constexpr double sparse_penalty = 3;
  return sparse_penalty * ordering.flops / 2;
}

CholeskyPlan require_dense_memory(CholeskyPlan plan) {
  plan.memory = DenseCholesky::memory(plan.pattern.order());
  require_memory(plan.memory, "a dense matrix of order " + std::to_string(plan.pattern.order()));
  return plan;
}

CholeskyPlan require_sparse_memory(CholeskyPlan plan) {
  plan.memory = SparseCholesky::memory(plan.pattern, plan.ordering);
  require_memory(plan.memory,
                 "a sparse factorisation of order " + std::to_string(plan.pattern.order()));
  return plan;
}

}  // namespace

CholeskyPlan plan_cholesky(SymmetricPattern pattern,
                           std::optional<SymmetricBlocks::Storage> storage) {
  using Storage = SymmetricBlocks::Storage;
  CholeskyPlan plan = {.pattern = std::move(pattern)};
  const double dense = dense_work(plan.pattern);
  if (storage ? *storage == Storage::sparse : !obviously_dense(plan.pattern)) {
    plan.ordering = find_ordering(plan.pattern);
    plan.work = sparse_work(plan.ordering);
    if (storage || plan.work <= dense) {
      plan.storage = Storage::sparse;
      return require_sparse_memory(std::move(plan));
    }
  }
  plan.work = dense;
  return require_dense_memory(std::move(plan));
}

std::unique_ptr<Cholesky> Cholesky::make(CholeskyPlan plan, ThreadPool& pool) {
  if (plan.storage == Storage::dense) return std::make_unique<Dense>(std::move(plan.pattern), pool);
  return std::make_unique<Sparse>(std::move(plan.pattern), plan.ordering);
}

}  // namespace raybundle::linalg
