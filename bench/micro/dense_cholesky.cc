// The dense Cholesky factorisation, n^3 / 3 multiplications and additions; beside it that of
// whatever LAPACK is linked, on one thread.

#include <chrono>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <raybundle/bench/micro/benchmarks.h>
#include <raybundle/linalg/blas_threads.h>
#include <raybundle/linalg/dense_cholesky.h>
#include <raybundle/linalg/parallel.h>

#ifdef RAYBUNDLE_HAVE_LAPACK
// NOLINTNEXTLINE(readability-identifier-naming): the name LAPACK gives it.
extern "C" void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
#endif

namespace raybundle::bench {
namespace {

using Matrix = std::vector<double>;

/// Symmetric, diagonally dominant, off-diagonal entries in [-1, 1).
Matrix random_spd(std::int64_t n) {
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  Matrix A(static_cast<std::size_t>(n * n));
  for (double& a : A) a = entry(generator);
  for (std::int64_t k = 0; k < n; ++k) {
    A[static_cast<std::size_t>(k * n + k)] = static_cast<double>(n);
  }
  return A;
}

/// Times factor(matrix), which says whether it went well, on a fresh copy each time.
template <class Factor>
void measure(benchmark::State& state, std::int64_t order, int threads, Factor&& factor) {
  using Clock = std::chrono::steady_clock;
  const Matrix original = random_spd(order);
  Matrix A;
  for (auto _ : state) {
    A = original;
    const auto start = Clock::now();
    const bool good = factor(A.data());
    state.SetIterationTime(std::chrono::duration<double>(Clock::now() - start).count());
    if (!good) state.SkipWithError("not positive definite");
  }
  report(state, {.bytes = 0, .flops = std::pow(static_cast<double>(order), 3) / 3}, threads);
}

void ours(benchmark::State& state, std::int64_t order, int threads) {
  linalg::ThreadPool pool(threads);
  linalg::DenseCholesky cholesky(order);
  measure(state, order, threads, [&](double* A) { return cholesky.factor(A, order, pool); });
}

#ifdef RAYBUNDLE_HAVE_LAPACK
void lapack(benchmark::State& state, std::int64_t order, int threads) {
  const linalg::SingleThreadedBlas blas;
  const int n = static_cast<int>(order);
  measure(state, order, threads, [&](double* A) {
    int info = 0;
    dpotrf_("L", &n, A, &n, &info);
    return info == 0;
  });
}
#endif

template <class Measure>
void add(const char* kernel, Measure measure_it, std::int64_t order, int threads) {
  const std::string name = std::string(kernel) + "/order:" + std::to_string(order) +
                           "/threads:" + std::to_string(threads);
  benchmark::RegisterBenchmark(name.c_str(), measure_it, order, threads)
      ->UseManualTime()
      ->MinTime(0.2)
      ->Unit(benchmark::kMillisecond);
}

}  // namespace

void register_dense_cholesky(std::int64_t order, int threads) {
  add("dense Cholesky", ours, order, threads);
#ifdef RAYBUNDLE_HAVE_LAPACK
  if (threads == 1) add("dense Cholesky of LAPACK", lapack, order, threads);
#endif
}

}  // namespace raybundle::bench
