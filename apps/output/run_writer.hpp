#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "libdem/bed.hpp"

/// Frames of a run: `run.h5` holds the numbers, `run.xdmf` beside it tells ParaView where and when they belong.
namespace subsoil::app {

/// What never changes about the spheres, in rising id. It stands once in the file, under /particles.
struct ParticleTable {
  std::vector<std::int64_t> id;
  std::vector<double> radius;   ///< m
  std::vector<double> density;  ///< kg/m^3
  std::vector<int> material;    ///< index into material_names
  std::vector<std::string> material_names;
};

/// A surface of triangles, or lines, or, with neither, points. One that moves has its vertices in its own axes and gets
/// a pose with every frame; one that deforms gets all of them with every frame; one that stands still has them in world
/// axes and is written once.
struct OutputSurface {
  std::string name;
  std::vector<dem::Vec3> vertices;  ///< m
  std::vector<std::array<int, 3>> triangles;
  bool moves = true;
  std::vector<std::array<int, 2>> segments{};
  bool deforms = false;
};

/// A number that every frame carries: name and unit.
struct FrameValue {
  std::string name, unit;
};

/// One moment. Spans are in rising particle id; those of columns that are not selected may be empty.
struct Frame {
  double time = 0;  ///< s
  long step = 0;
  std::span<const std::int64_t> id;  ///< who is left; empty: everybody in the particle table
  std::span<const dem::Vec3> position, velocity, spin, force, torque;
  std::span<const int> contacts;
  std::span<const int> bonds{};  ///< empty where no law has any
  std::span<const dem::Pose>
      surfaces;  ///< one per surface of the list, in its order; of fixed and deforming surfaces it is not read
  std::span<const std::vector<dem::Vec3>> deformed{};  ///< vertices in world axes, one list per deforming surface
  std::span<const double> values{};                    ///< as RunOptions::values; may be empty
};

/// How numbers are kept. `rounded` is float32 whose last bits are noise to physics and are set to zero, because they
/// are what does not compress: positions to at most 1e-4 of the smallest radius (1 micrometre for 10 mm), everything
/// else to a relative 3e-5.
enum class FramePrecision { rounded, float32, float64 };

struct FrameBox {
  dem::Vec3 low, high;  ///< m, world axes; a sphere belongs when its centre lies inside
};

struct RunOptions {
  FramePrecision precision = FramePrecision::rounded;
  std::set<std::string> columns = all_columns();  ///< position always stands
  std::optional<FrameBox> region;
  long expected_frames = 256;  ///< places made in advance; more frames are possible, see RunWriter
  int compression = 1;         ///< gzip level 0..9
  std::string title;
  std::vector<FrameValue> values{};

  static std::set<std::string> all_columns();  ///< position velocity spin force torque contacts
};

/// Writes DIR/run.h5 and DIR/run.xdmf.
///
/// A killed run keeps its frames, and its file can be walked by any reader. HDF5 has no journal, so nothing that an
/// earlier frame needs is touched again: the groups /frames/000000, 000001, ... are made when the file is made; a frame
/// goes to new space at the end of the file without a name, is flushed, and then appears in its group by one small
/// write; its `written` turns from 0 to 1, and last a rename puts the XDMF in place that names it. (One file per frame
/// would be as safe but litters; SWMR mode leaves a mark in a killed file that readers refuse.) Only beyond
/// `expected_frames` + 64 are more groups added, at a moment's risk. The file is not locked: a run can be looked at
/// while it goes on.
class RunWriter {
 public:
  RunWriter(const std::filesystem::path& directory, ParticleTable particles, std::vector<OutputSurface> surfaces,
            RunOptions options);
  ~RunWriter();
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  void write(const Frame& frame);
  /// The table of all bonds that broke, /broken bonds: time s, ids, position m, energy J, mode 0 tension or 1 shear.
  /// To be called once, at the end; nothing is written for none.
  void write_broken_bonds(std::span<const dem::BrokenBond> broken);
  long frames() const;
  /// Closes the file and drops the places not used. The destructor does so too, but cannot report.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace subsoil::app
