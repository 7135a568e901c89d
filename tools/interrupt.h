#pragma once

namespace raybundle::tools {

/// While it lives, the first SIGINT or SIGTERM only raises a flag, so that a solve can end with its
/// best state; the second has its usual effect, at once. A signal that was ignored stays ignored.
/// One at a time.
class InterruptGuard {
 public:
  /// `announce`: the first signal is answered on standard error.
  explicit InterruptGuard(bool announce);
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// The signal that came, by name ("SIGINT"); null while there was none.
  const char* signal() const;
};

}  // namespace raybundle::tools
