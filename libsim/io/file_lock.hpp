#pragma once
#include <filesystem>

namespace subsoil::sim {

/// A lock of the system on a file, which goes with the process however it ends.
class FileLock {
 public:
  /// Makes the file where there is none. Throws std::runtime_error when it cannot be opened.
  explicit FileLock(const std::filesystem::path& file);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  /// Takes the lock, and waits for another process that has it, for that time at most (s). Whether it was taken.
  bool take(double patience);

 private:
  int descriptor_;
};

/// Waits until no process locks the file, for that time at most (s); whether none does, or there is no such file.
bool await_unlocked(const std::filesystem::path& file, double patience);

}  // namespace subsoil::sim
