#include "apps/output/read_guard.hpp"

#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstring>

#include "apps/input_limits.hpp"

namespace subsoil::app::h5 {
namespace {

constexpr std::array<int, 5> deadly{SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGPROF};
thread_local bool armed = false;
std::array<char, 4096> path_read{};  // a handler may not allocate

void say(const char* text) {
  if (::write(STDERR_FILENO, text, std::strlen(text)) < 0) return;
}

/// Only calls that a signal handler may make (POSIX, 2.4.3).
void refuse_file(int signal) {
  say("subsoil: ");
  say(path_read.data());
  say(signal == SIGPROF ? ": the HDF5 library comes to no end with this file"
                        : ": the HDF5 library fails at this file");
  say(": it is damaged, or no HDF5 file of a run; take it from its source "
      "again\n");
  _exit(2);
}

/// Of processor time, until SIGPROF; 0: never.
void set_timer(long seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = seconds;
  setitimer(ITIMER_PROF, &timer, nullptr);
}

long longest_read() {
  constexpr long slowest = 50'000'000;  // bytes per second; ours come with 300 MB/s and more
  struct stat file {};
  const long bytes = stat(path_read.data(), &file) == 0 ? static_cast<long>(file.st_size) : 0;
  return static_cast<long>(input_limits().read_seconds) + bytes / slowest;
}

}  // namespace

ReadGuard::ReadGuard(hid_t object) {
  if (armed) return;
  path_read[0] = '\0';
  H5Fget_name(object, path_read.data(), path_read.size());
  arm();
}

ReadGuard::ReadGuard(const std::string& path) {
  if (armed) return;
  path_read[path.copy(path_read.data(), path_read.size() - 1)] = '\0';
  arm();
}

void ReadGuard::arm() {
  const long seconds = longest_read();
  struct sigaction action {};
  action.sa_handler = refuse_file;
  for (std::size_t i = 0; i < deadly.size(); ++i) sigaction(deadly[i], &action, &before_[i]);
  set_timer(seconds);
  armed = outermost_ = true;
}

ReadGuard::~ReadGuard() {
  if (!outermost_) return;
  set_timer(0);
  for (std::size_t i = 0; i < deadly.size(); ++i) sigaction(deadly[i], &before_[i], nullptr);
  armed = false;
}

}  // namespace subsoil::app::h5
