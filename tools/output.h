#pragma once

#include <string>
#include <string_view>

/// Where results go: files, or "-" for standard output.
namespace raybundle::tools {

/// Throws std::system_error when `output` could not be written: its folder does not exist, it is a
/// folder itself, may not be written, ... Leaves no trace. To be called before long work.
void check_output(const std::string& output);

/// Whether two names stand for one file, or both for standard output.
bool same_file(const std::string& a, const std::string& b);

/// Throws OptionError when --output and --log name one file. Empty names are no outputs.
void check_apart(const std::string& output, const std::string& log);

/// A result must not replace what it was made from, nor a file of a folder that it was made from,
/// and is never compressed: throws OptionError naming `option` for such an `output`,
/// std::system_error as check_output() does. An empty name is no output, or no input.
void check_result(const std::string& option, const std::string& output, const std::string& input);

/// Where "-" stands for standard output, a name that stands for it elsewhere too.
std::string output_path(const std::string& output);

/// Writes a report to standard output. Throws std::system_error, but not when the reader of a pipe
/// has seen enough and closed it.
void print(std::string_view text);

/// A report: the same, or on standard error where a result has taken standard output.
void print_report(const std::string& report, bool standard_output_taken);

/// How an output is called in reports.
std::string shown_name(const std::string& output);

/// What formats do not hold of a problem.
inline constexpr const char* without_points =
    "a folder in ParallaxBA's format has no points: who reads it places them by their rays";
inline constexpr const char* square_pixels =
    "BAL has square pixels: those of the file are all as wide as f_x tells, which weighs their "
    "rows otherwise, and the cost is another";

/// Whether a result of this name is to be a folder: it is one, or ends in a slash.
bool names_folder(const std::string& output);

/// Whatever keeps a problem from being written to the folder `output`, which need not exist: throws
/// OptionError naming `option` when it is a file, the input, or holds a problem already;
/// std::system_error when it could not be written.
void check_folder(const std::string& option, const std::string& output, const std::string& input);

}  // namespace raybundle::tools
