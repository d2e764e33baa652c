#pragma once
#include <csignal>

namespace subsoil::sim {

/// The signal that came since the last guard was made, SIGINT or SIGTERM; 0: none.
int caught_signal();

/// Catches SIGINT and SIGTERM for the time of a run; a second one of the same kind ends the program at once.
class SignalGuard {
 public:
  SignalGuard();
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;

 private:
  struct sigaction old_int_ {
  }, old_term_{};
};

}  // namespace subsoil::sim
