#pragma once

#include <cstdint>

namespace raybundle::tools {

/// The most memory this process has had in use so far, bytes.
std::int64_t peak_memory();

}  // namespace raybundle::tools
