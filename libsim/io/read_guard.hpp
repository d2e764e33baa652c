#pragma once
#include <hdf5.h>
#include <sys/resource.h>

#include <array>
#include <csignal>
#include <string>

namespace subsoil::sim::h5 {

/// Stands in front of calls that read a file which may be damaged. HDF5 1.10 itself can fall over one: it reads at
/// address 0 where the header of a group is broken, and goes in a circle where a heap of texts is. While a guard lives,
/// such a signal (SIGSEGV, SIGBUS, SIGFPE, SIGABRT), and more processor time than a file of this size can take
/// (SIGPROF; InputLimits::read_seconds), ends the program with exit code 2 and the file's name, as any other damage
/// does. Lengths in a damaged file ask for gigabytes: beyond what a file of this size can hold unpacked (RLIMIT_DATA;
/// InputLimits::read_bytes) the library gets none, and reports a failure. What was set before is set again afterwards,
/// so that a crash of our own stays one. For the thread that reads; guards may nest. Some microseconds.
class ReadGuard {
 public:
  /// `object`: the file or something in it.
  explicit ReadGuard(hid_t object);
  explicit ReadGuard(const std::string& path);
  ~ReadGuard();
  ReadGuard(const ReadGuard&) = delete;
  ReadGuard& operator=(const ReadGuard&) = delete;

 private:
  void arm();
  std::array<struct sigaction, 5> before_{};
  rlimit memory_before_{};
  bool outermost_ = false;
};

}  // namespace subsoil::sim::h5
