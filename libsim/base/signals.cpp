#include "libsim/base/signals.hpp"

namespace subsoil::sim {
namespace {
volatile std::sig_atomic_t caught = 0;
void on_signal(int signal) { caught = signal; }
}  // namespace

int caught_signal() { return caught; }

SignalGuard::SignalGuard(Second second) {
  caught = 0;
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = second == Second::ends_at_once ? static_cast<int>(SA_RESETHAND) : 0;
  sigaction(SIGINT, &action, &old_int_);
  sigaction(SIGTERM, &action, &old_term_);
}

SignalGuard::~SignalGuard() {
  sigaction(SIGINT, &old_int_, nullptr);
  sigaction(SIGTERM, &old_term_, nullptr);
}

}  // namespace subsoil::sim
