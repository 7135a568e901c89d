#pragma once

#include <functional>
#include <string>

namespace CLI {  // NOLINT(readability-identifier-naming): theirs
class App;
}

/// The subcommands of the program, one file each.
namespace raybundle::tools {

/// What the program tells its caller. The same table stands in `raybundle -h`.
enum class ExitCode {
  usable = 0,             ///< converged, or a limit reached with a lower cost
  failure = 1,            ///< an output could not be written, or the system refused something
  usage = 2,              ///< unknown, ineffective or contradicting options
  bad_input = 3,          ///< the input says something else than it should
  numerical_failure = 4,  ///< no usable result; the best state was written all the same
  no_memory = 5,
  interrupted = 6,  ///< by SIGINT or SIGTERM; the best state was written
};

/// A subcommand as the parser knows it, and what runs when it was chosen.
struct Command {
  CLI::App* parser;
  std::function<ExitCode()> run;
};

/// Each adds its subcommand to the program. Running one throws OptionError, InputError,
/// std::system_error (an output) and std::bad_alloc.
Command add_solve(CLI::App& program);
Command add_info(CLI::App& program);
Command add_init(CLI::App& program);
Command add_rotations(CLI::App& program);
Command add_convert(CLI::App& program);
Command add_eval(CLI::App& program);
Command add_increments(CLI::App& program);
Command add_generate(CLI::App& program);
Command add_bench(CLI::App& program);
Command add_version(CLI::App& program);

/// Help of the INPUT argument of all subcommands.
extern const char* const input_help;

}  // namespace raybundle::tools
