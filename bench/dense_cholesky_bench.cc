// GFlop/s (n^3 / 3 per factorisation) of DenseCholesky beside LAPACK's dpotrf from whatever BLAS is
// linked, and the time of one solve. Usage: dense_cholesky_bench [threads] [order...]
// The number of threads LAPACK uses is its own affair (for OpenBLAS: OPENBLAS_NUM_THREADS).

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <raybundle/linalg/cpu.h>
#include <raybundle/linalg/dense_cholesky.h>
#include <raybundle/linalg/parallel.h>

// NOLINTNEXTLINE(readability-identifier-naming): the name LAPACK gives it.
extern "C" void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);

namespace {

using raybundle::linalg::DenseCholesky;
using raybundle::linalg::ThreadPool;
using Matrix = std::vector<double>;

/// Symmetric, diagonally dominant, off-diagonal entries in [-1, 1).
Matrix random_spd(std::int64_t n) {
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  Matrix A(static_cast<std::size_t>(n * n));
  for (double& a : A) a = entry(generator);
  for (std::int64_t k = 0; k < n; ++k)
    A[static_cast<std::size_t>(k * n + k)] = static_cast<double>(n);
  return A;
}

/// The shortest time of `work`, with `prepare` outside the clock, over at least 0.3 s and 3 runs.
template <class Prepare, class Work>
double best_seconds(Prepare&& prepare, Work&& work) {
  using Clock = std::chrono::steady_clock;
  double best = 1e300;
  double total = 0.0;
  for (int run = 0; run < 3 || total < 0.3; ++run) {
    prepare();
    const auto start = Clock::now();
    work();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    best = std::min(best, seconds);
    total += seconds;
  }
  return best;
}

void measure(std::int64_t n, ThreadPool& pool) {
  const Matrix original = random_spd(n);
  Matrix A = original;
  const auto restore = [&] { std::copy(original.begin(), original.end(), A.begin()); };
  const double gflop =
      static_cast<double>(n) * static_cast<double>(n) * static_cast<double>(n) / 3e9;

  int info = 0;
  const int order = static_cast<int>(n);
  const double lapack =
      best_seconds(restore, [&] { dpotrf_("L", &order, A.data(), &order, &info); });

  DenseCholesky cholesky(n);
  bool good = true;
  const double ours =
      best_seconds(restore, [&] { good = cholesky.factor(A.data(), n, pool) && good; });
  std::vector<double> b(static_cast<std::size_t>(n));
  const double solve = best_seconds([&] { std::fill(b.begin(), b.end(), 1.0); },
                                    [&] { cholesky.solve(A.data(), n, b.data()); });
  std::printf("%6d %10.1f %10.1f %8.2f %12.1f %12.1f%s\n", order, gflop / ours, gflop / lapack,
              lapack / ours, ours * 1e6, solve * 1e6, good && info == 0 ? "" : "  FAILED");
}

}  // namespace

int main(int argc, char** argv) {
  ThreadPool pool(argc > 1 ? std::atoi(argv[1]) : 1);
  std::vector<std::int64_t> orders;
  for (int i = 2; i < argc; ++i) orders.push_back(std::atoll(argv[i]));
  if (orders.empty()) orders = {144, 189, 441, 900, 1800, 4000};
  std::printf("%d threads, %s\n", pool.threads(),
              std::string(raybundle::linalg::name(raybundle::linalg::instruction_set())).c_str());
  std::printf("%6s %10s %10s %8s %12s %12s\n", "order", "GFlop/s", "dpotrf", "ratio", "factor us",
              "solve us");
  for (const std::int64_t n : orders) measure(n, pool);
  return 0;
}
