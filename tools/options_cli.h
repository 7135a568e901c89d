#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <raybundle/solver/init/initialize.h>
#include <raybundle/solver/options.h>

namespace CLI {  // NOLINT(readability-identifier-naming): theirs
class App;
}

namespace raybundle::tools {

/// Adds all options of the option table (solver/option_table.h) to a subcommand, with their help
/// and defaults; parsing writes to `options`, which must outlive it. A value that is not one makes
/// parsing throw OptionError.
void add_solver_options(CLI::App& parser, Options& options);

/// The same of the table of initialisation (solver/init/option_table.h).
void add_init_options(CLI::App& parser, init::InitializeOptions& options);

/// The options that `words`, "--name value" one after the other, set. Throws OptionError for words
/// that are no option of the table.
Options parse_solver_options(const std::vector<std::string>& words);

/// The seed that `text` is, all of it. Throws OptionError naming `option`.
std::uint64_t parse_seed(const std::string& option, const std::string& text);

/// A size with its unit, such as 1.5GiB, in bytes. Throws OptionError naming `option`.
double parse_size(const std::string& option, const std::string& text);

/// A check for names of files: an empty one, from an unset variable perhaps, must not pass for
/// none.
std::string has_name(const std::string& name);

}  // namespace raybundle::tools
