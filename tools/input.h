#pragma once

#include <string>

#include <raybundle/models/problem.h>

namespace raybundle::tools {

/// Reads what INPUT names: a BAL file or, for "-", standard input; either may be compressed (gzip,
/// bzip2, xz, zstd, told by the first bytes). Throws InputError.
Problem read_input(const std::string& input);

}  // namespace raybundle::tools
