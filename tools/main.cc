// The command line: finds the subcommand, runs it, and turns what goes wrong into exit codes.

#include <fcntl.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <raybundle/linalg/cpu.h>
#include <raybundle/linalg/memory.h>
#include <raybundle/models/error.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/output.h>
#include <raybundle/version.h>

namespace {

using raybundle::tools::Command;
using raybundle::tools::ExitCode;

constexpr const char* description =
    "raybundle: bundle adjustment. Without an INPUT, `raybundle solve` solves a small street "
    "scene.";
constexpr const char* options_footer =
    "Options of a subcommand: raybundle SUBCOMMAND -h; of all of them: raybundle --help-all\n\n";
constexpr const char* footer =
    R"(Results go to standard output or the file named, progress and warnings to standard error.

Exit codes:
  0  usable result: converged, or a limit was reached with a lower cost (or allowed no step)
  1  an output could not be written, or the system refused something else
  2  usage: an option is unknown, has no effect or contradicts another
  3  bad input
  4  numerical failure; the best state was written
  5  not enough memory; a solve that had begun has written its best state
  6  interrupted; the best state was written)";

/// Descriptors 0 to 2 are always taken, so that no output file is mistaken for one of them.
/// Writing to a stand-in fails, as writing to the closed descriptor did.
void occupy_standard_descriptors() {
  for (int descriptor = 0; descriptor <= STDERR_FILENO; ++descriptor) {
    if (::fcntl(descriptor, F_GETFD) != -1) continue;
    if (::open("/dev/null", O_RDONLY) < 0) return;
  }
}

/// Memory that has been freed goes back to the system at once, so that the process is as large as
/// what it holds; glibc by itself would keep more of it the larger the pieces it has seen freed.
void return_freed_memory() {
#ifdef M_MMAP_THRESHOLD
  constexpr int large = 1 << 22;
  ::mallopt(M_MMAP_THRESHOLD, large);
#endif
}

ExitCode complain(const std::string& message, ExitCode code) {
  std::fputs((message + "\n").c_str(), stderr);
  return code;
}

/// Figures of other kernels than were asked for would mislead.
void check_environment() {
  const std::string ignored = raybundle::linalg::ignored_instruction_set();
  if (ignored.empty()) return;
  throw raybundle::OptionError("RAYBUNDLE_ISA: '" + ignored +
                               "' is none of baseline, avx2, avx512");
}

ExitCode run(const Command& command) {
  try {
    check_environment();
    return command.run();
  } catch (const raybundle::OptionError& error) {
    return complain(std::string("raybundle: ") + error.what(), ExitCode::usage);
  } catch (const raybundle::InputError& error) {
    return complain(error.what(), ExitCode::bad_input);
  } catch (const raybundle::linalg::MemoryRefusal& refusal) {
    return complain(std::string("raybundle: not enough memory: ") + refusal.what(),
                    ExitCode::no_memory);
  } catch (const std::bad_alloc&) {
    return complain("raybundle: not enough memory", ExitCode::no_memory);
  } catch (const std::exception& error) {
    return complain(std::string("raybundle: ") + error.what(), ExitCode::failure);
  }
}

ExitCode usage_error(const CLI::App& program, std::string message) {
  std::string name = "raybundle";
  if (program.get_subcommands().empty() && !program.remaining().empty()) {
    message = "'" + program.remaining().front() + "' is neither a subcommand nor an option";
  }
  for (const CLI::App* chosen : program.get_subcommands()) name += " " + chosen->get_name();
  return complain("raybundle: " + message + " (see " + name + " -h)", ExitCode::usage);
}

ExitCode run_program(int argc, char** argv) {
  CLI::App program(description, "raybundle");
  program.footer(footer);  // the subcommands take it over
  program.get_formatter()->column_width(32);
  program.set_help_all_flag("--help-all", "Print the help of all subcommands and exit");
  program.set_version_flag("--version", raybundle::version);
  program.require_subcommand(1);
  const std::vector<Command> commands = {
      raybundle::tools::add_solve(program),     raybundle::tools::add_init(program),
      raybundle::tools::add_rotations(program), raybundle::tools::add_info(program),
      raybundle::tools::add_eval(program),      raybundle::tools::add_convert(program),
      raybundle::tools::add_generate(program),  raybundle::tools::add_increments(program),
      raybundle::tools::add_bench(program),     raybundle::tools::add_version(program)};
  program.footer(std::string(options_footer) + footer);
  try {
    program.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    raybundle::tools::print(program.help());  // of the subcommand, when there is one
    return ExitCode::usable;
  } catch (const CLI::CallForAllHelp&) {
    raybundle::tools::print(program.help("", CLI::AppFormatMode::All));
    return ExitCode::usable;
  } catch (const CLI::CallForVersion& call) {
    raybundle::tools::print(call.what() + std::string("\n"));
    return ExitCode::usable;
  } catch (const CLI::ParseError& error) {
    return usage_error(program, error.what());
  } catch (const raybundle::OptionError& error) {
    return usage_error(program, error.what());
  }
  const auto chosen = std::find_if(commands.begin(), commands.end(),
                                   [](const Command& command) { return command.parser->parsed(); });
  return run(*chosen);
}

}  // namespace

int main(int argc, char** argv) {
  // A reader that goes away is an error of one write, not the end of a long solve.
  std::signal(SIGPIPE, SIG_IGN);
  occupy_standard_descriptors();
  return_freed_memory();
  try {
    return static_cast<int>(run_program(argc, argv));
  } catch (const std::exception& error) {
    return static_cast<int>(complain(std::string("raybundle: ") + error.what(), ExitCode::failure));
  }
}
