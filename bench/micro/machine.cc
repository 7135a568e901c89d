#include <raybundle/bench/micro/machine.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <stdexcept>

#include <raybundle/bench/micro/peak.h>
#include <raybundle/linalg/large_vector.h>
#include <raybundle/linalg/parallel.h>

namespace raybundle::bench {

#ifdef RAYBUNDLE_HAVE_X86_KERNELS
namespace avx512 {
extern const PeakLoop loop;
}
namespace avx2 {
extern const PeakLoop loop;
}
#endif
namespace baseline {
extern const PeakLoop loop;
}

PeakLoop peak_loop(linalg::InstructionSet set) {
#ifdef RAYBUNDLE_HAVE_X86_KERNELS
  if (set == linalg::InstructionSet::avx512) return avx512::loop;
  if (set == linalg::InstructionSet::avx2) return avx2::loop;
#endif
  static_cast<void>(set);
  return baseline::loop;
}

namespace {

/// Other work on the machine only slows down: the best of many short runs is what it can do.
constexpr int runs = 12;

template <class Work>
double best_seconds(Work&& work) {
  using Clock = std::chrono::steady_clock;
  double best = 1e300;
  for (int run = 0; run < runs; ++run) {
    const auto start = Clock::now();
    work();
    best = std::min(best, std::chrono::duration<double>(Clock::now() - start).count());
  }
  return best;
}

// Three arrays of 128 MB, cut evenly among the threads; each thread has written its part first. 24
// bytes an element are counted, not the 8 more that a cache reads before it writes.
double measure_triad(linalg::ThreadPool& pool) {
  constexpr std::int64_t count = 16'000'000;
  linalg::LargeVector<double> a(count), b(count), c(count);
  const linalg::Chunks parts = linalg::chunks(count, 1, pool.threads());
  const auto for_parts = [&](auto&& body) {
    pool.run(parts.pieces, [&](std::int64_t part) {
      const std::int64_t end = parts.end(part);
      for (std::int64_t i = parts.begin(part); i < end; ++i) body(static_cast<std::size_t>(i));
    });
  };
  for_parts([&](std::size_t i) { a[i] = b[i] = c[i] = 1.0; });
  const double seconds =
      best_seconds([&] { for_parts([&](auto i) { a[i] = b[i] + 3.0 * c[i]; }); });
  return 24e-9 * count / seconds;
}

double measure_peak(linalg::ThreadPool& pool) {
  constexpr std::int64_t rounds = 4'000'000;
  const PeakLoop loop = peak_loop();
  bool finite = true;
  const double seconds = best_seconds([&] {
    pool.run(pool.threads(), [&](std::int64_t) {
      if (!(loop.run(rounds) < 1e300)) finite = false;
    });
  });
  if (!finite) throw std::runtime_error("the loop that measures peak flops does not converge");
  return 1e-9 * loop.flops * rounds * pool.threads() / seconds;
}

}  // namespace

const Machine& machine(int threads) {
  static std::map<int, Machine> known;
  const auto found = known.find(threads);
  if (found != known.end()) return found->second;
  linalg::ThreadPool pool(threads);
  return known[threads] = {measure_triad(pool), measure_peak(pool)};
}

}  // namespace raybundle::bench
