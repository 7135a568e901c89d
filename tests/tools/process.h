#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <raybundle/tests/support/temporary_folder.h>

namespace raybundle::test {

using Words = std::vector<std::string>;

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The program under test as a child process. What it prints goes to files of its own folder.
class Process {
 public:
  /// `input`: what it reads from standard input. `output`: a descriptor for its standard output
  /// instead of the file.
  explicit Process(const std::vector<std::string>& arguments,
                   const std::filesystem::path& input = "/dev/null", int output = -1) {
    std::vector<std::string> words = {RAYBUNDLE_CLI};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv(words.size() + 1, nullptr);
    for (std::size_t i = 0; i < words.size(); ++i) argv[i] = words[i].data();
    const int in = ::open(input.c_str(), O_RDONLY | O_CLOEXEC);
    const int out = output >= 0 ? ::dup(output) : create("out");
    const int err = create("err");
    child_ = ::fork();
    if (child_ == 0) {  // only async-signal-safe calls until exec
      ::dup2(in, STDIN_FILENO);
      ::dup2(out, STDOUT_FILENO);
      ::dup2(err, STDERR_FILENO);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
    for (const int descriptor : {in, out, err}) ::close(descriptor);
    if (child_ < 0) throw std::system_error(errno, std::generic_category(), "fork");
  }
  ~Process() {
    if (child_ <= 0) return;
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void signal(int number) const { ::kill(child_, number); }

  /// The exit code; that of a shell (128 + signal) for a child that was killed.
  int wait() {
    if (child_ > 0) {
      int status = 0;
      while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) {
      }
      code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      child_ = 0;
    }
    return code_;
  }

  /// Waits until `text` stands on standard error. False when the child ended without it.
  bool wait_for_error_text(const std::string& text) {
    for (;;) {
      const bool ended = has_ended();
      if (errors().find(text) != std::string::npos) return true;
      if (ended) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  std::string output() const { return read_text(folder_ / "out"); }
  std::string errors() const { return read_text(folder_ / "err"); }

 private:
  int create(const char* name) const {
    return ::open((folder_ / name).c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  }
  bool has_ended() const {
    siginfo_t info{};
    ::waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOHANG | WNOWAIT);
    return info.si_pid == child_;
  }

  TemporaryFolder folder_;
  pid_t child_ = 0;
  int code_ = -1;
};

/// What a run that ended by itself left behind.
struct Result {
  int code;
  std::string output;
  std::string errors;
};

inline Result run(const std::vector<std::string>& arguments,
                  const std::filesystem::path& input = "/dev/null") {
  Process process(arguments, input);
  const int code = process.wait();
  return {code, process.output(), process.errors()};
}

}  // namespace raybundle::test
