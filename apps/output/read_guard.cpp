#include "apps/output/read_guard.hpp"

#include <unistd.h>

#include <cstring>

namespace subsoil::app::h5 {
namespace {

constexpr std::array<int, 4> deadly{SIGSEGV, SIGBUS, SIGFPE, SIGABRT};
thread_local bool armed = false;
std::array<char, 4096> path_read{};  // a handler may not allocate

void say(const char* text) {
  if (::write(STDERR_FILENO, text, std::strlen(text)) < 0) return;
}

/// Only calls that a signal handler may make (POSIX, 2.4.3).
void refuse_file(int) {
  say("subsoil: ");
  say(path_read.data());
  say(": the HDF5 library fails at this file: it is damaged, or no HDF5 file of a run; take it from its source "
      "again\n");
  _exit(2);
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
  struct sigaction action {};
  action.sa_handler = refuse_file;
  for (std::size_t i = 0; i < deadly.size(); ++i) sigaction(deadly[i], &action, &before_[i]);
  armed = outermost_ = true;
}

ReadGuard::~ReadGuard() {
  if (!outermost_) return;
  for (std::size_t i = 0; i < deadly.size(); ++i) sigaction(deadly[i], &before_[i], nullptr);
  armed = false;
}

}  // namespace subsoil::app::h5
