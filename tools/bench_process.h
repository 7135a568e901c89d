#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <raybundle/tools/interrupt.h>

/// Other programs as child processes that are held to limits and measured.
namespace raybundle::tools {

/// Whether limits of memory can be kept: a sanitizer maps terabytes of shadow that count as data,
/// and the program started is most often this one.
bool limits_memory();

struct ProcessRequest {
  std::vector<std::string> command;  ///< the program, as a path, and its arguments
  std::vector<std::pair<std::string, std::string>> environment = {};  ///< in addition to ours
  std::filesystem::path folder = {};                         ///< it works there; empty: where we do
  double seconds = std::numeric_limits<double>::infinity();  ///< then SIGTERM, ...
  double grace = 5;                                          ///< ... and after these SIGKILL
  /// Most memory it may have, 0 for no limit: of its data in the sense of RLIMIT_DATA, which since
  /// Linux 4.7 is the heap and every private writable mapping. The address space (RLIMIT_AS) would
  /// also count mapped input files and what threads reserve and never touch. Without effect where
  /// limits_memory() is false.
  std::uint64_t bytes = 0;
  const InterruptGuard* interrupt = nullptr;  ///< a signal that it saw ends the child
};

struct ProcessResult {
  int code = -1;                ///< exit code; -1 when a signal ended it
  int signal = 0;               ///< that signal
  bool timed_out = false;       ///< ended by us because of the time
  bool interrupted = false;     ///< ended by us because of a signal that we got
  double seconds = 0;           ///< wall-clock time
  std::int64_t peak_bytes = 0;  ///< largest resident set
  std::string output = {};      ///< what it printed, both streams, up to some thousand characters
};

/// Runs a program to its end. This process sleeps meanwhile. The child gets no input and is killed
/// when we die. Throws std::system_error when no process can be made; a program that cannot be
/// run ends with code 127.
ProcessResult run_process(const ProcessRequest& request);

/// "exit code 3", "signal 9".
std::string describe(const ProcessResult& result);

/// What it complained about, in one line: the last that it printed (but of the Ceres driver, which
/// shows its options after it, the complaint itself); of one that was silent, how it ended.
std::string complaint(const ProcessResult& result);

/// Where PATH has a program of this name; empty: nowhere.
std::filesystem::path find_program(const std::string& name);

}  // namespace raybundle::tools
