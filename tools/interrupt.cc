#include <raybundle/tools/interrupt.h>

#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <string_view>

namespace raybundle::tools {
namespace {

constexpr std::array handled = {SIGINT, SIGTERM};

volatile std::sig_atomic_t received = 0;
volatile std::sig_atomic_t announces = 0;

void set_handler(int signal, void (*handler)(int)) {
  struct sigaction action {};
  ::sigaction(signal, nullptr, &action);
  if (action.sa_handler == SIG_IGN) return;
  action = {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  ::sigaction(signal, &action, nullptr);
}

// Nothing but async-signal-safe calls.
void receive(int signal) {
  const int before = errno;
  received = signal;
  for (const int each : handled) set_handler(each, SIG_DFL);
  if (announces != 0) {
    constexpr std::string_view text =
        "interrupted: ends after this iteration with the best state; once more to quit at once\n";
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text.data(), text.size());
  }
  errno = before;
}

}  // namespace

InterruptGuard::InterruptGuard(bool announce) {
  received = 0;
  announces = announce ? 1 : 0;
  for (const int each : handled) set_handler(each, receive);
}

InterruptGuard::~InterruptGuard() {
  for (const int each : handled) set_handler(each, SIG_DFL);
}

const char* InterruptGuard::signal() const {
  if (received == 0) return nullptr;
  return received == SIGINT ? "SIGINT" : "SIGTERM";
}

}  // namespace raybundle::tools
