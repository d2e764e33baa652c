#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "libsim/io/frame.hpp"
#include "libsim/io/frame_parts.hpp"

/// Frames of a run: `run.h5` holds the numbers, `run.xdmf` beside it tells ParaView where and when they belong.
namespace subsoil::sim {

/// Which frames are on the disk: of each the number of the first frame in its file.
struct WrittenFrames {
  std::vector<std::int64_t> file_of;
};

/// Writes DIR/frames/000000.h5, 000001.h5, ..., DIR/run.h5 and DIR/run.xdmf.
///
/// HDF5 has no journal: whoever writes into a file can lose all of it when the power goes. So a file that is complete
/// is never opened again. Frames go into files of their own, which are written under another name, forced to the disk
/// and renamed; what frames share lies in frames/static.h5. run.h5 holds links only, /frames/000000 and so on, so that
/// any reader of HDF5 finds all of a run under one name, and is rewritten for each frame in the same way, as is the
/// XDMF. A frame that either of them names is on the disk. Alternatives that lost: one file with ordered writes stands
/// a kill but no cut of the power (1 of 10 then does not open); SWMR mode leaves a mark that readers refuse after a
/// kill, and forces nothing to the disk (docs/reliability.md has the cost of each).
///
/// Waiting for the disk takes a twentieth of the time at most: frames that come faster share a file, named by its
/// first frame, and appear together, some ten times as late as the disk is slow. publish() makes them appear now.
///
/// With `parts` each of several processes writes the spheres that it has, into files of its own (part_writer.hpp),
/// which are on the disk before a frame is named; the frame has links to them, /frames/000000/parts/00 and so on.
class RunWriter {
 public:
  /// Throws DiskFault, as do all that write.
  /// @param go_on what an earlier writer into this directory kept: its frames stay, later ones go
  /// @param parts who writes the spheres; null: this writer does, of the spans of the frame. Outlives the writer
  RunWriter(const std::filesystem::path& directory, ParticleTable particles, std::vector<OutputSurface> surfaces,
            RunOptions options, const WrittenFrames& go_on = {}, FrameParts* parts = nullptr);
  ~RunWriter();
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  void write(const Frame& frame);
  /// The table of all bonds that broke, /broken bonds: time s, ids, position m, energy J, mode 0 tension, 1 shear, 2
  /// edge. To be called once, at the end; nothing is written for none.
  void write_broken_bonds(std::span<const dem::BrokenBond> broken);
  long frames() const;
  const ParticleTable& particles() const;
  /// All frames so far are on the disk and named when this returns. Returns from what a later writer can continue.
  WrittenFrames publish();
  /// The same, for the last time. The destructor does so too, but cannot report.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace subsoil::sim
