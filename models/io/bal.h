#pragma once

#include <raybundle/models/problem.h>

#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>

/// Bundle Adjustment in the Large (BAL) text files: a header "cameras points observations", a line
/// "camera point x y" per observation, then nine numbers per camera and three per point.
namespace raybundle::io {

/// Reads a plain-text BAL file. Throws InputError (file, line, found, expected) for anything that
/// is not exactly one well-formed problem of finite numbers, with at least one camera, point and
/// observation. Header and observations stand on a line each; parameters may be divided by any
/// white space. Line ends may be CR LF. `threads` read it, 0 means all cores; how many makes no
/// difference to what is read or thrown.
Problem read_bal(const std::filesystem::path& path, int threads = 0);

/// The same from memory; `source` names the text in errors.
Problem parse_bal(std::string_view text, const std::string& source, int threads = 0);

/// Writes the shortest decimals that read back to the same doubles, whole or not at all: the
/// file appears under its name only when complete. What is fixed is not part of the format, and
/// pixels are square in it: y is divided by the aspect. The bytes are the same for any number of
/// threads, 0 meaning all cores. Throws
/// InputError for a problem that is not valid, std::system_error (naming the file) on failure.
void write_bal(const Problem& problem, const std::filesystem::path& path, int threads = 0);

/// The same to an open stream.
void write_bal(const Problem& problem, std::ostream& out, int threads = 0);

}  // namespace raybundle::io
