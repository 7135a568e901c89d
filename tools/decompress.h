#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace raybundle::tools {

enum class Compression { none, gzip, bzip2, xz, zstd };

/// By the first bytes; names of files say nothing.
Compression detect_compression(std::string_view bytes);

/// The content of one or more compressed streams of one kind, one after another. Sizes promised in
/// headers are not believed: memory grows only with what comes out. Throws InputError naming
/// `source` for damaged or incomplete data, for something else after it, and when more than
/// `most_bytes` come out.
std::string decompress(std::string_view packed, Compression kind, const std::string& source,
                       std::int64_t most_bytes);

}  // namespace raybundle::tools
