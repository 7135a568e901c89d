#pragma once

#include <string>

#include <raybundle/models/error.h>
#include <raybundle/models/problem.h>

namespace raybundle::tools {

/// Reads what INPUT names: a folder in ParallaxBA's format, a BAL file or, for "-", standard input;
/// the last two may be compressed (gzip, bzip2, xz, zstd, told by the first bytes). `threads` read
/// it, 0 means all cores. Throws InputError.
Problem read_input(const std::string& input, int threads = 0);

/// Reads what is known to be true of a problem: a BAL file, or cameras without points from a file
/// in ParallaxBA's columns, six numbers a line, or from such a folder (whose points would only be
/// guessed from its rays). Files may be "-" or compressed as above; the first line tells which
/// format it is. Throws InputError.
Problem read_truth(const std::string& truth);

/// What use() returns; an InputError about "problem" or "truth" names the file it was read from.
template <class Use>
auto naming(const char* what, const std::string& file, const Use& use) {
  try {
    return use();
  } catch (const InputError& error) {
    if (error.source() != what) throw;
    throw InputError(file == "-" ? "standard input" : file, error.line(), error.found(),
                     error.expected());
  }
}

}  // namespace raybundle::tools
