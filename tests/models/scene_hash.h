#pragma once

#include <raybundle/models/problem.h>

#include <bit>
#include <cstdint>
#include <vector>

namespace raybundle::test {

/// FNV-1a over 64-bit words: the same on machines of either byte order.
class Hash {
 public:
  void add(std::uint64_t word) {
    for (int k = 0; k < 8; ++k, word >>= 8) value_ = (value_ ^ (word & 0xFF)) * 0x100000001B3U;
  }
  void add(double x) { add(std::bit_cast<std::uint64_t>(x)); }
  void add(const std::vector<double>& values) {
    for (const double x : values) add(x);
  }
  void add(const std::vector<std::int32_t>& values) {
    for (const std::int32_t i : values) add(static_cast<std::uint64_t>(i));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325U;
};

inline std::uint64_t hash(const Problem& problem) {
  Hash result;
  result.add(problem.cameras);
  result.add(problem.points);
  result.add(problem.observation_camera);
  result.add(problem.observation_point);
  result.add(problem.observations);
  return result.value();
}

}  // namespace raybundle::test
