#pragma once

#include <cstdint>

namespace raybundle {

/// Random numbers that are the same bits on every machine and compiler: a 64-bit counter through a
/// mixing function, and own maps to uniform and normal numbers. These use + - * / and sqrt only,
/// which IEEE 754 rounds correctly; their source is compiled without fused multiply-add.
class Random {
 public:
  /// Different (seed, stream) pairs give unrelated sequences.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0);

  std::uint64_t bits();                     ///< 64 random bits
  double uniform();                         ///< in [0, 1), a multiple of 2^-53
  double uniform(double low, double high);  ///< in [low, high)
  double normal();                          ///< mean 0, standard deviation 1
  std::int64_t below(std::int64_t count);   ///< in [0, count), count >= 1

 private:
  std::uint64_t counter_;
};

}  // namespace raybundle
