#include <raybundle/tools/bench_stamp.h>

#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <iterator>
#include <system_error>

#include <nlohmann/json.hpp>

#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/parallaxba.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr std::array<const char*, run_status_count> status_names = {
    "ok", "failed", "no-memory", "time-limit", "crashed", "refused", "error", "interrupted"};

/// The hash called FNV-1a, of 64 bits: tells builds apart, which nobody forges here.
std::uint64_t hash_of(std::istream& in) {
  std::uint64_t hash = 0xcbf29ce484222325;
  std::array<char, 1 << 16> buffer;
  while (in.read(buffer.data(), buffer.size()) || in.gcount() > 0) {
    for (std::streamsize i = 0; i < in.gcount(); ++i) {
      hash =
          (hash ^ static_cast<unsigned char>(buffer[static_cast<std::size_t>(i)])) * 0x100000001b3;
    }
  }
  return hash;
}

std::string file_stamp(const fs::path& path) {
  if (io::is_parallaxba(path)) {
    const io::ParallaxBaFiles files = io::parallaxba_files(path);
    return file_stamp(files.cameras) + ", " + file_stamp(files.features) + ", " +
           file_stamp(files.calibration);
  }
  struct stat file {};
  if (::stat(path.c_str(), &file) != 0) {
    throw std::system_error(errno, std::generic_category(), path.string());
  }
  return format("%lld bytes, time %lld.%09ld", static_cast<long long>(file.st_size),
                static_cast<long long>(file.st_mtim.tv_sec), file.st_mtim.tv_nsec);
}

/// Solvers say it in several ways when an allocation fails; the last is that of a thread's stack.
bool speaks_of_memory(const std::string& output) {
  for (const char* words :
       {"bad_alloc", "emory allocation", "not enough memory", "Resource temporarily unavailable"}) {
    if (output.find(words) != std::string::npos) return true;
  }
  return false;
}

/// What a stamp begins with.
std::string variant_stamp(const BenchVariant& variant, const BenchArguments& arguments) {
  std::string stamp = variant.solver == BenchSolver::ceres ? "ceres" : "raybundle";
  for (const std::string& word : variant.options) stamp += " '" + word + "'";
  return stamp + format("; memory limit %llu; program ",
                        static_cast<unsigned long long>(arguments.memory_limit));
}

RunStatus status_of(const ProcessResult& result, BenchSolver solver, bool has_log) {
  if (result.interrupted) return RunStatus::interrupted;
  if (result.timed_out) return RunStatus::time_limit;
  if (result.code == 0) return has_log ? RunStatus::ok : RunStatus::error;
  if (speaks_of_memory(result.output)) return RunStatus::no_memory;
  if (result.signal != 0) return RunStatus::crashed;
  if (result.code == 127) return RunStatus::refused;
  if (solver == BenchSolver::ceres) {
    return result.code == 2 ? RunStatus::refused : RunStatus::error;
  }
  switch (static_cast<ExitCode>(result.code)) {
    case ExitCode::numerical_failure:
      return has_log ? RunStatus::failed : RunStatus::error;
    case ExitCode::no_memory:
      return RunStatus::no_memory;
    case ExitCode::usage:
    case ExitCode::bad_input:
      return RunStatus::refused;
    case ExitCode::interrupted:
      return RunStatus::interrupted;
    default:
      return RunStatus::error;
  }
}

}  // namespace

const char* name(RunStatus status) { return status_names[static_cast<std::size_t>(status)]; }

BenchProgram bench_program(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::system_error(errno, std::generic_category(), path.string());
  return {path, format("%016llx", static_cast<unsigned long long>(hash_of(in)))};
}

std::string run_stamp(const BenchProblem& problem, const BenchVariant& variant,
                      const BenchArguments& arguments, const BenchProgram& program,
                      const std::string& processor) {
  std::string stamp = variant_stamp(variant, arguments) + program.hash;
  stamp += "; problem of " + file_stamp(problem.file);
  if (!problem.truth.empty()) stamp += "; truth of " + file_stamp(problem.truth);
  return stamp + "; on " + processor;
}

bool is_of_variant(const std::string& stamp, const BenchVariant& variant,
                   const BenchArguments& arguments) {
  return stamp.starts_with(variant_stamp(variant, arguments));
}

RunOutcome judge(const ProcessResult& result, BenchSolver solver, bool has_log,
                 const std::string& stamp) {
  RunOutcome outcome;
  outcome.stamp = stamp;
  outcome.status = status_of(result, solver, has_log);
  outcome.code = result.code;
  outcome.signal = result.signal;
  outcome.wall_seconds = result.seconds;
  outcome.peak_bytes = result.peak_bytes;
  if (outcome.status == RunStatus::ok || outcome.status == RunStatus::failed) return outcome;
  outcome.message = complaint(result);
  return outcome;
}

bool stands(const RunOutcome& outcome, const std::string& stamp, bool has_log) {
  if (outcome.stamp != stamp) return false;
  switch (outcome.status) {
    case RunStatus::ok:
    case RunStatus::failed:
      return has_log;
    case RunStatus::no_memory:
    case RunStatus::time_limit:
    case RunStatus::crashed:
      return true;
    default:
      return false;
  }
}

void save_outcome(const fs::path& file, const RunOutcome& outcome) {
  const Json json = {{"stamp", outcome.stamp},
                     {"status", name(outcome.status)},
                     {"code", outcome.code},
                     {"signal", outcome.signal},
                     {"seconds", outcome.wall_seconds},
                     {"peak_bytes", outcome.peak_bytes},
                     {"message", outcome.message}};
  io::write_file_atomically(file, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::optional<RunOutcome> load_outcome(const fs::path& file) {
  try {
    const Json json = Json::parse(file_text(file));
    RunOutcome outcome;
    json.at("stamp").get_to(outcome.stamp);
    json.at("code").get_to(outcome.code);
    json.at("signal").get_to(outcome.signal);
    json.at("seconds").get_to(outcome.wall_seconds);
    json.at("peak_bytes").get_to(outcome.peak_bytes);
    json.at("message").get_to(outcome.message);
    const std::string status = json.at("status");
    for (std::size_t i = 0; i < status_names.size(); ++i) {
      if (status != status_names[i]) continue;
      outcome.status = static_cast<RunStatus>(i);
      return outcome;
    }
  } catch (const Json::exception&) {
    return std::nullopt;
  }
  return std::nullopt;
}

std::string file_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace raybundle::tools
