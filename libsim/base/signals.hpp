#pragma once
#include <csignal>

namespace subsoil::sim {

/// The signal that came since the last guard was made, SIGINT or SIGTERM; 0: none.
int caught_signal();

/// Catches SIGINT and SIGTERM for the time of a run or of a study.
class SignalGuard {
 public:
  /// What a second signal of the same kind does: ends the program at once, or waits as the first.
  enum class Second { ends_at_once, waits };
  explicit SignalGuard(Second second = Second::ends_at_once);
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;

 private:
  struct sigaction old_int_ {
  }, old_term_{};
};

}  // namespace subsoil::sim
