#pragma once
#include <filesystem>
#include <string>

#include "libdem/particles/particles.hpp"
#include "libsim/io/frame.hpp"

namespace subsoil::sim {

/// Which frame a part is of, and where it lies: in the file that is named by its first frame.
struct PartPlace {
  long frame = 0, first = 0;
};

/// Spheres that lie on many processes, as the writer of frames sees them from one of these: each writes a part of every
/// frame (part_writer.hpp). All members act on all processes; a fault of any is thrown here, as DiskFault.
class FrameParts {
 public:
  virtual ~FrameParts() = default;
  virtual int count() const = 0;  ///< of processes
  /// From here on processes keep their spheres of instants for frames and write them into this folder.
  /// @param quantum of positions that are rounded, m
  virtual void open(const std::filesystem::path& directory, double quantum) = 0;
  /// Returns the grids of the parts for the XDMF, in the order of the processes.
  virtual std::string write(const PartPlace& place, const Between& between) = 0;
  /// All parts so far are on the disk under their names when this returns.
  virtual void publish() = 0;
  /// Throws away what publish() has not named.
  virtual void drop() = 0;
  /// Spheres of the last instant, for a state; and back from one.
  virtual dem::Snapshot gather() = 0;
  virtual void restore(const dem::Snapshot& spheres) = 0;
};

}  // namespace subsoil::sim
