#include "libsim/io/file_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <thread>

namespace subsoil::sim {

bool await_unlocked(const std::filesystem::path& file, double patience) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience);
  const int opened = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (opened < 0) return true;
  bool unlocked = false;
  while (!(unlocked = ::flock(opened, LOCK_EX | LOCK_NB) == 0) && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  ::close(opened);
  return unlocked;
}

}  // namespace subsoil::sim
