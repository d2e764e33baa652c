#pragma once
#include <string>
#include <vector>

#include "libsim/io/hdf5.hpp"

namespace subsoil::sim {

/// The spheres of a frame, whether they lie in it or, of a run on many processes, in parts (part_writer.hpp): those are
/// joined, in rising id.
class JoinedFrame {
 public:
  /// @param group /frames/000012 of an open run.h5. Throws std::runtime_error with the name of a part that is missing
  JoinedFrame(hid_t file, std::string group);

  /// Whether the frame, or each of its parts, has an array of this name.
  bool holds(const std::string& name) const;
  /// An array of the frame, or of its parts by sphere: rows in rising id. Throws std::runtime_error where parts do not
  /// fit together: a sphere in two of them, an array with fewer rows than spheres.
  template <class T>
  std::vector<T> read(const std::string& name) const;
  /// Path of such an array in the file; of parts that of the first.
  std::string place(const std::string& name) const;
  bool in_parts() const { return !parts_.empty(); }

 private:
  const std::vector<std::size_t>& order() const;
  hid_t file_;
  std::string group_;
  std::vector<std::string> parts_;          ///< their groups
  mutable std::vector<std::size_t> order_;  ///< of the rows of all parts, behind each other; filled when it is needed
};

}  // namespace subsoil::sim
