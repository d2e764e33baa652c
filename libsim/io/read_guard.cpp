#include "libsim/io/read_guard.hpp"

#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "libsim/base/input_limits.hpp"

#ifdef __SANITIZE_ADDRESS__  // GCC
#define SUBSOIL_ADDRESS_SANITIZER
#elif defined(__has_feature)  // clang
#if __has_feature(address_sanitizer)
#define SUBSOIL_ADDRESS_SANITIZER
#endif
#endif

namespace subsoil::sim::h5 {
namespace {

constexpr std::array<int, 5> deadly{SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGPROF};
// Initial-exec: the library may be linked into a module that a program loads.
[[gnu::tls_model("initial-exec")]] thread_local bool armed = false;
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

rlim_t size_of_file() {
  struct stat file {};
  return stat(path_read.data(), &file) == 0 ? static_cast<rlim_t>(file.st_size) : 0;
}

long longest_read() {
  constexpr rlim_t slowest = 50'000'000;  // bytes per second; ours come with 300 MB/s and more
  return static_cast<long>(input_limits().read_seconds + size_of_file() / slowest);
}

/// What this process has of what RLIMIT_DATA counts, bytes; 0: not known.
rlim_t memory_in_use() {
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  if (file == nullptr) return 0;
  rlim_t pages = 0;
  const bool found = std::fscanf(file, "%*u %*u %*u %*u %*u %lu", &pages) == 1;
  std::fclose(file);
  return found ? pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) : 0;
}

/// Until `before` is set again. Not under the address sanitizer, whose own memory counts and must not fail.
void bound_memory(const rlimit& before) {
#ifndef SUBSOIL_ADDRESS_SANITIZER
  constexpr rlim_t deflate = 1032;  // its greatest ratio, of a run of equal bytes
  const rlim_t in_use = memory_in_use();
  if (in_use == 0) return;
  rlimit bound = before;
  bound.rlim_cur = std::min(before.rlim_cur, in_use + input_limits().read_bytes + deflate * size_of_file());
  setrlimit(RLIMIT_DATA, &bound);
#else
  static_cast<void>(before);
#endif
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
  getrlimit(RLIMIT_DATA, &memory_before_);
  bound_memory(memory_before_);
  armed = outermost_ = true;
}

ReadGuard::~ReadGuard() {
  if (!outermost_) return;
  set_timer(0);
  setrlimit(RLIMIT_DATA, &memory_before_);
  for (std::size_t i = 0; i < deadly.size(); ++i) sigaction(deadly[i], &before_[i], nullptr);
  armed = false;
}

}  // namespace subsoil::sim::h5
