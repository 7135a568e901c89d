#pragma once

#include <string>
#include <string_view>

/// Where results go: files, or "-" for standard output.
namespace raybundle::tools {

/// Throws std::system_error when `output` could not be written: its folder does not exist, it is a
/// folder itself, may not be written, ... Leaves no trace. To be called before long work.
void check_output(const std::string& output);

/// Whether two names stand for one file, or for standard output.
bool same_file(const std::string& a, const std::string& b);

/// The checks of a result that `option` names: that it does not replace `input` (may be empty),
/// which it was made from, and is not called compressed (OptionError); check_output(). Nothing for
/// an empty name.
void check_result(const std::string& option, const std::string& output, const std::string& input);

/// Where "-" stands for standard output, a name that stands for it elsewhere too.
std::string output_path(const std::string& output);

/// Writes a report to standard output. Throws std::system_error, but not when the reader of a pipe
/// has seen enough and closed it.
void print(std::string_view text);

}  // namespace raybundle::tools
