#include <raybundle/linalg/cholesky.h>

#include <raybundle/linalg/blas_threads.h>
#include <raybundle/linalg/cholmod_cholesky.h>
#include <raybundle/linalg/cpu.h>
#include <raybundle/linalg/dense_cholesky.h>
#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/supernodal_cholesky.h>

#include <utility>

namespace raybundle::linalg {
namespace {

using Storage = SymmetricBlocks::Storage;

std::string with_kernels() { return " with " + std::string(name(instruction_set())) + " kernels"; }

class Dense final : public Cholesky {
 public:
  Dense(SymmetricPattern pattern, ThreadPool& pool)
      : Cholesky(std::move(pattern), Storage::dense),
        order_(matrix().pattern().order()),
        cholesky_(order_),
        pool_(pool) {}

  bool factor() override { return cholesky_.factor(matrix().values(), order_, pool_); }
  void solve(double* x) override { cholesky_.solve(matrix().values(), order_, x); }
  CholeskyKind kind() const override { return CholeskyKind::dense; }
  std::string description() const override {
    return "dense Cholesky of order " + std::to_string(order_) + with_kernels();
  }

 private:
  std::int64_t order_;
  DenseCholesky cholesky_;
  ThreadPool& pool_;
};

class Sparse final : public Cholesky {
 public:
  Sparse(CholeskyPlan plan, ThreadPool& pool)
      : Cholesky(std::move(plan.pattern), Storage::sparse),
        method_(plan.ordering.method),
        cholesky_(matrix().pattern(), std::move(plan.supernodes), pool) {}

  bool factor() override { return cholesky_.factor(matrix()); }
  void solve(double* x) override { cholesky_.solve(x); }
  CholeskyKind kind() const override { return CholeskyKind::sparse; }
  std::string description() const override {
    return "sparse Cholesky of order " + std::to_string(matrix().pattern().order()) + " by " +
           method_ + with_kernels();
  }

 private:
  std::string method_;
  SupernodalCholesky cholesky_;
};

class Cholmod final : public Cholesky {
 public:
  explicit Cholmod(CholeskyPlan plan)
      : Cholesky(std::move(plan.pattern), Storage::sparse),
        method_(plan.ordering.method),
        cholesky_(matrix().pattern(), plan.ordering) {}

  bool factor() override { return cholesky_.factor(matrix()); }
  void solve(double* x) override { cholesky_.solve(x); }
  CholeskyKind kind() const override { return CholeskyKind::cholmod; }
  std::string description() const override {
    return "sparse Cholesky of order " + std::to_string(matrix().pattern().order()) + " by " +
           method_ + " (CHOLMOD, " + blas_name() + ")";
  }

 private:
  std::string method_;
  CholmodCholesky cholesky_;
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

const char* adjective(CholeskyKind kind) {
  return kind == CholeskyKind::dense ? "dense" : "sparse";
}

}  // namespace

CholeskyPlan plan_cholesky(SymmetricPattern pattern, int threads,
                           std::optional<CholeskyKind> kind) {
  CholeskyPlan plan = {.pattern = std::move(pattern)};
  const double dense = front_work(static_cast<double>(plan.pattern.order()), 0);
  if (kind ? *kind != CholeskyKind::dense : !obviously_dense(plan.pattern)) {
    plan.ordering = find_ordering(plan.pattern);
    plan.supernodes = find_supernodes(plan.pattern, plan.ordering.permutation);
    plan.work = factor_work(plan.supernodes);
    plan.sparse_memory = SupernodalCholesky::memory(plan.pattern, plan.supernodes, threads);
    plan.kind = kind.value_or(plan.work < dense ? CholeskyKind::sparse : CholeskyKind::dense);
  }
  if (plan.kind == CholeskyKind::dense) {
    plan.work = dense;
    plan.memory = DenseCholesky::memory(plan.pattern.order());
  } else if (plan.kind == CholeskyKind::sparse) {
    plan.memory = plan.sparse_memory;
  } else {
    plan.memory = CholmodCholesky::memory(plan.pattern, plan.ordering);
  }
  return plan;
}

std::unique_ptr<Cholesky> Cholesky::make(CholeskyPlan plan, ThreadPool& pool) {
  require_memory(plan.memory, std::string("a ") + adjective(plan.kind) +
                                  " factorisation of order " +
                                  std::to_string(plan.pattern.order()));
  if (plan.kind == CholeskyKind::dense) {
    return std::make_unique<Dense>(std::move(plan.pattern), pool);
  }
  if (plan.kind == CholeskyKind::sparse) return std::make_unique<Sparse>(std::move(plan), pool);
  return std::make_unique<Cholmod>(std::move(plan));
}

}  // namespace raybundle::linalg
