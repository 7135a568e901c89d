#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include <raybundle/tools/bench_plan.h>
#include <raybundle/tools/bench_process.h>

/// What is kept of a run beside its log, and whether it need not be repeated.
namespace raybundle::tools {

enum class RunStatus {
  ok,           ///< ended with a usable result
  failed,       ///< numerical failure
  no_memory,    ///< had not enough, or more than its limit
  time_limit,   ///< was ended, long after the time at which it should have stopped
  crashed,      ///< by a signal that we did not send
  refused,      ///< does not take the options or the problem
  error,        ///< an output could not be written, ...
  interrupted,  ///< by a signal that we got
};
inline constexpr int run_status_count = 8;
const char* name(RunStatus status);

struct RunOutcome {
  std::string stamp;  ///< all that the run depended on, in one line
  RunStatus status = RunStatus::error;
  int code = -1;
  int signal = 0;
  double wall_seconds = 0;
  std::int64_t peak_bytes = 0;
  std::string message;  ///< the last line that it printed, when it did not end well
};

/// A program and what tells its builds apart.
struct BenchProgram {
  std::filesystem::path path;
  std::string hash;  ///< of its content
};
/// Throws std::system_error when the file cannot be read.
BenchProgram bench_program(const std::filesystem::path& path);

/// Everything that a run's outcome and speed depend on: options, limits, content of the program,
/// size and time of the files of problem and truth, processor. Names of folders are no part of it,
/// so that all can be moved. Throws std::system_error when a file is not there.
std::string run_stamp(const BenchProblem& problem, const BenchVariant& variant,
                      const BenchArguments& arguments, const BenchProgram& program,
                      const std::string& processor);

/// Whether a run with this stamp was made with the options and limits of this variant, whatever the
/// program and the files.
bool is_of_variant(const std::string& stamp, const BenchVariant& variant,
                   const BenchArguments& arguments);

/// How a run ended. `has_log`: whether it left one.
RunOutcome judge(const ProcessResult& result, BenchSolver solver, bool has_log,
                 const std::string& stamp);

/// An earlier outcome that stands: it has this stamp, the run came to an end of its own, and its
/// log is there if it should be.
bool stands(const RunOutcome& outcome, const std::string& stamp, bool has_log);

/// Files NAME.run.json. Reading gives nothing for a file that is absent, torn or somebody else's.
void save_outcome(const std::filesystem::path& file, const RunOutcome& outcome);
std::optional<RunOutcome> load_outcome(const std::filesystem::path& file);

/// The content of a file; empty when it cannot be read.
std::string file_text(const std::filesystem::path& file);

}  // namespace raybundle::tools
