#pragma once

#include <raybundle/solver/options.h>

namespace CLI {  // NOLINT(readability-identifier-naming): theirs
class App;
}

namespace raybundle::tools {

/// Adds all options of the option table (solver/option_table.h) to a subcommand, with their help
/// and defaults; parsing writes to `options`, which must outlive it. A value that is not one makes
/// parsing throw OptionError.
void add_solver_options(CLI::App& parser, Options& options);

}  // namespace raybundle::tools
