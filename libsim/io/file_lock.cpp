#include "libsim/io/file_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>
#include <thread>

namespace subsoil::sim {

namespace {

bool lock(int descriptor, double patience) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience);
  bool locked = false;
  while (!(locked = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0) && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return locked;
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& file)
    : descriptor_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
  if (descriptor_ < 0)
    throw std::runtime_error("cannot write " + file.string() + ": is the folder writable, the disk full?");
}

FileLock::~FileLock() { ::close(descriptor_); }

bool FileLock::take(double patience) { return lock(descriptor_, patience); }

bool await_unlocked(const std::filesystem::path& file, double patience) {
  const int opened = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (opened < 0) return true;
  const bool unlocked = lock(opened, patience);
  ::close(opened);
  return unlocked;
}

}  // namespace subsoil::sim
