#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "libsim/io/array_file.hpp"
#include "libsim/io/frame.hpp"
#include "libsim/io/frame_parts.hpp"

namespace subsoil::sim {

/// Of the part that process `rank` writes, from the folder of the run: frames/000012.rank-03.h5.
std::string part_file(long first, int rank);
/// frames/000012.h5, beside which the parts of its frames lie.
std::string frames_file(long first);
/// /frames/000012, in the parts too.
std::string frame_group(long frame);

/// Writes the spheres that one of several processes has, frame by frame: DIR/frames/000012.rank-03.h5 holds
/// /frames/000012 with the arrays of a frame that carries its own ids (position, velocity, ..., id, radius, density,
/// material), rows in rising id. As any file of frames it has another name until it is whole and on the disk: a kill or
/// a full disk leaves the parts of earlier frames, which are never opened again.
class PartWriter {
 public:
  /// Throws std::invalid_argument where this process does not see the folder that is there on the first.
  /// @param quantum of positions that are rounded, m: the same on all processes
  PartWriter(const std::filesystem::path& directory, int rank, RunOptions options, double quantum);

  /// Spheres of this process, all of them in the table, in its order. Returns its grid for the XDMF; nothing where none
  /// of them lies in the region. Throws DiskFault.
  std::string write(const PartPlace& place, const ParticleTable& own, const Frame& frame);
  void publish();  ///< what is written is on the disk under its name
  void drop() { file_.drop(); }

 private:
  std::filesystem::path directory_;
  int rank_;
  RunOptions options_;
  double quantum_;
  ArrayFile file_;
  std::uint64_t bytes_ = 0;  ///< maximum of the files so far
};

}  // namespace subsoil::sim
