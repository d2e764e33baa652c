#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "libsim/io/hdf5.hpp"

namespace subsoil::sim::h5 {

/// What went wrong with a file that is being written; none so far: 0.
struct WriteStatus {
  std::filesystem::path path;
  int error = 0;             ///< errno of the first operation that failed
  std::uint64_t needed = 0;  ///< bytes that the file was about to have
  /// Throws DiskFault if anything failed.
  void check() const;
};

/// A file driver whose writes never fail in HDF5's eyes. HDF5 1.10 does not come back from a failed one: it crashes
/// when the file is closed, or at exit. This driver keeps the first failure, and what could not be written in memory,
/// so that the library reads back what it wrote and closes the file in order; whoever writes asks status_of(). What
/// lies on the disk then is no file of results: it has a temporary name and is thrown away.
/// It locks nothing: results can be looked at during a run; the folder of a run has a lock of its own.
hid_t checked_driver();

/// Of a file that create_file() made; outlives the file.
std::shared_ptr<WriteStatus> status_of(hid_t file);
/// Closes such a file; throws DiskFault if any of its writes failed. A Handle that just goes closes it without a word.
void close_file(Handle& file);

/// Makes `name` lead to an object of another file, whose path is relative to this one's folder.
void link_external(hid_t file, const std::string& name, const std::string& target_file, const std::string& target);

}  // namespace subsoil::sim::h5
