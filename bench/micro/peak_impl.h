// The loop of peak.h. Included once per instruction set, with RAYBUNDLE_ISA its name.

#include <cstdint>

#include <raybundle/bench/micro/peak.h>

namespace raybundle::bench::RAYBUNDLE_ISA {

extern const PeakLoop loop;

namespace {

#if defined(__AVX512F__)
constexpr int bytes = 64;
#elif defined(__AVX2__)
constexpr int bytes = 32;
#else
constexpr int bytes = 16;
#endif
constexpr int width = bytes / 8;
// Chains that do not wait for one another: two operations begin per cycle and each takes about
// four, so that at least eight are needed; with the two factors they fit 16 registers.
constexpr int chains = 10;

using Vector [[gnu::vector_size(bytes)]] = double;

double run(std::int64_t rounds) {
  Vector chain[chains];
  Vector a, b;
  for (int i = 0; i < width; ++i) {
    a[i] = 0.5;
    b[i] = 1.0 + i;
  }
  for (int k = 0; k < chains; ++k) chain[k] = b * (1.0 + k);
  for (std::int64_t round = 0; round < rounds; ++round) {
#pragma GCC unroll 10
    for (int k = 0; k < chains; ++k) chain[k] = chain[k] * a + b;
  }
  double sum = 0;
  for (const Vector& x : chain) {
    for (int i = 0; i < width; ++i) sum += x[i];
  }
  return sum;
}

}  // namespace

const PeakLoop loop = {2.0 * chains * width, &run};

}  // namespace raybundle::bench::RAYBUNDLE_ISA
