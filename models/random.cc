// Built with -ffp-contract=off: a fused multiply-add would change the last bits.

#include <raybundle/models/random.h>

#include <cmath>

namespace raybundle {
namespace {

constexpr std::uint64_t golden_step = 0x9E3779B97F4A7C15U;  // 2^64 / golden ratio, odd

/// The finaliser of SplitMix64 [Steele14]: every input bit reaches every output bit.
std::uint64_t mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9U;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBU;
  return x ^ (x >> 31);
}

/// ln(x) for x in (0, 1] without the C library, whose last bit differs between systems:
/// x = m 2^e with m in [1/2, 1), and ln m = 2 artanh((m - 1) / (m + 1)) by its series.
double natural_log(double x) {
  int exponent = 0;
  const double m = std::frexp(x, &exponent);
  const double z = (m - 1) / (m + 1);
  const double z2 = z * z;
  double sum = 0;
  for (int k = 16; k >= 0; --k) sum = sum * z2 + 1.0 / (2 * k + 1);
  constexpr double ln2 = 0.693147180559945309417;
  return 2 * z * sum + exponent * ln2;
}

}  // namespace

Random::Random(std::uint64_t seed, std::uint64_t stream)
    : counter_(mix(seed + golden_step) ^ mix(mix(stream) + 2 * golden_step)) {}

std::uint64_t Random::bits() {
  counter_ += golden_step;
  return mix(counter_);
}

double Random::uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }

double Random::uniform(double low, double high) { return low + (high - low) * uniform(); }

// Marsaglia's polar method; the second number it offers is not kept, so that the state stays one
// counter.
double Random::normal() {
  while (true) {
    const double x = uniform(-1, 1);
    const double y = uniform(-1, 1);
    const double s = x * x + y * y;
    if (s > 0 && s < 1) return x * std::sqrt(-2 * natural_log(s) / s);
  }
}

std::int64_t Random::below(std::int64_t count) {
  // The bias of the remainder is below count / 2^64.
  return static_cast<std::int64_t>(bits() % static_cast<std::uint64_t>(count));
}

}  // namespace raybundle
