#pragma once

#include <cstdint>

namespace raybundle::linalg {

/// Of the numbers that rows of a Jacobian are stored in; all that is computed from them is summed
/// in double precision.
enum class Precision { single_precision, double_precision };

constexpr std::int64_t bytes(Precision precision) {
  return precision == Precision::single_precision ? 4 : 8;
}

}  // namespace raybundle::linalg
