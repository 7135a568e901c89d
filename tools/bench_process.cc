#include <raybundle/tools/bench_process.h>

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <sstream>
#include <system_error>

#include <raybundle/linalg/sanitized.h>

namespace raybundle::tools {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::size_t most_output = 4000;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// A file descriptor, closed at the end.
class Descriptor {
 public:
  Descriptor(int number, const char* what) : number_(number) {
    if (number < 0) fail(what);
  }
  ~Descriptor() { ::close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

/// Holds SIGINT and SIGTERM back except where they are waited for, so that none slips in between
/// the look at the flag and the wait.
class SignalsHeld {
 public:
  SignalsHeld() {
    sigset_t held;
    sigemptyset(&held);
    sigaddset(&held, SIGINT);
    sigaddset(&held, SIGTERM);
    ::pthread_sigmask(SIG_BLOCK, &held, &before_);
  }
  ~SignalsHeld() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;
  const sigset_t& before() const { return before_; }

 private:
  sigset_t before_;
};

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> all(words.size() + 1, nullptr);
  for (std::size_t i = 0; i < words.size(); ++i) all[i] = words[i].data();
  return all;
}

std::vector<std::string> environment(const ProcessRequest& request) {
  std::vector<std::string> all;
  for (char** each = ::environ; *each != nullptr; ++each) {
    const std::string entry = *each;
    const bool replaced =
        std::any_of(request.environment.begin(), request.environment.end(),
                    [&](const auto& own) { return entry.starts_with(own.first + "="); });
    if (!replaced) all.push_back(entry);
  }
  for (const auto& [name, value] : request.environment) all.push_back(name + "=" + value);
  return all;
}

/// In the child: only async-signal-safe calls.
[[noreturn]] void become(const ProcessRequest& request, char* const* arguments,
                         char* const* variables, int input, int output, const sigset_t& signals,
                         pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);  // it died before that took effect
  for (const int each : {SIGINT, SIGTERM}) {
    struct sigaction action {};
    ::sigaction(each, nullptr, &action);
    if (action.sa_handler == SIG_IGN) continue;
    action.sa_handler = SIG_DFL;
    ::sigaction(each, &action, nullptr);
  }
  ::pthread_sigmask(SIG_SETMASK, &signals, nullptr);
  ::dup2(input, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(output, STDERR_FILENO);
  if (request.bytes > 0 && limits_memory()) {
    const struct rlimit limit = {request.bytes, request.bytes};
    ::setrlimit(RLIMIT_DATA, &limit);
  }
  if (!request.folder.empty() && ::chdir(request.folder.c_str()) != 0) ::_exit(127);
  ::execve(arguments[0], arguments, variables);
  ::_exit(127);
}

/// Waits until the child has ended; true. False when `seconds` are over or a signal came.
bool ended(int child, double seconds, const sigset_t& signals) {
  struct timespec limit {};
  const bool limited = seconds < 1e9;
  if (limited) {
    const double whole = std::floor(std::max(seconds, 0.0));
    limit.tv_sec = static_cast<time_t>(whole);
    limit.tv_nsec = static_cast<long>((std::max(seconds, 0.0) - whole) * 1e9);
  }
  struct pollfd wait = {child, POLLIN, 0};
  return ::ppoll(&wait, 1, limited ? &limit : nullptr, &signals) > 0;
}

/// Sends the signals that limits and interruptions ask for until the child has ended.
void watch(const ProcessRequest& request, pid_t child, Clock::time_point start,
           const sigset_t& signals, ProcessResult& result) {
  // Not by its function: the header of glibc 2.36 forgets that it is C.
  const Descriptor handle(static_cast<int>(::syscall(SYS_pidfd_open, child, 0)), "pidfd_open");
  const auto was_interrupted = [&] {
    return request.interrupt != nullptr && request.interrupt->signal() != nullptr;
  };
  while (!was_interrupted()) {
    const double left = request.seconds - seconds_since(start);
    if (left <= 0) break;
    if (ended(handle.number(), left, signals)) return;
  }
  result.interrupted = was_interrupted();
  result.timed_out = !result.interrupted;
  ::kill(child, SIGTERM);
  const auto told = Clock::now();
  while (true) {
    const double left = request.grace - seconds_since(told);
    if (left <= 0) break;
    if (ended(handle.number(), left, signals)) return;
  }
  ::kill(child, SIGKILL);
}

std::string read_all(int file) {
  std::string text(most_output, '\0');
  const off_t size = ::lseek(file, 0, SEEK_END);  // the end tells more than the beginning
  const off_t from = std::max<off_t>(0, size - static_cast<off_t>(most_output));
  const ssize_t got = ::pread(file, text.data(), text.size(), from);
  text.resize(got < 0 ? 0 : static_cast<std::size_t>(got));
  return text;
}

}  // namespace

bool limits_memory() { return !linalg::sanitized; }

ProcessResult run_process(const ProcessRequest& request) {
  std::vector<std::string> words = request.command;
  std::vector<std::string> variables = environment(request);
  const std::vector<char*> argv = pointers(words);
  const std::vector<char*> envp = pointers(variables);
  const Descriptor input(::open("/dev/null", O_RDONLY | O_CLOEXEC), "/dev/null");
  const Descriptor output(::memfd_create("output", MFD_CLOEXEC), "memfd_create");
  const SignalsHeld held;
  const pid_t parent = ::getpid();

  const auto start = Clock::now();
  const pid_t child = ::fork();
  if (child < 0) fail("fork");
  if (child == 0) {
    become(request, argv.data(), envp.data(), input.number(), output.number(), held.before(),
           parent);
  }
  ProcessResult result;
  try {
    watch(request, child, start, held.before(), result);
  } catch (...) {
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    throw;
  }
  int status = 0;
  struct rusage usage {};
  while (::wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  result.seconds = seconds_since(start);
  if (WIFEXITED(status)) result.code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  result.peak_bytes = std::int64_t{usage.ru_maxrss} * 1024;
  result.output = read_all(output.number());
  return result;
}

std::string describe(const ProcessResult& result) {
  if (result.signal != 0) return "signal " + std::to_string(result.signal);
  return "exit code " + std::to_string(result.code);
}

std::string complaint(const ProcessResult& result) {
  std::string text = result.output;
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  if (text.empty()) return describe(result);
  std::size_t from = text.find("ceres_driver: ");
  if (from == std::string::npos) from = text.rfind('\n') + 1;  // npos + 1 is 0
  return text.substr(from, text.find('\n', from) - from);
}

std::filesystem::path find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    auto candidate = std::filesystem::path(folder) / name;
    if (!folder.empty() && ::access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  return {};
}

}  // namespace raybundle::tools
