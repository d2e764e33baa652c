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
///
/// Of a moving bed it is that of one period: sphere `id` is like sphere `id` mod n, and lay, before anything disturbed
/// it, at `at_rest` of that, id/n whole periods further along x. Its frames always carry what their spheres are.
struct ParticleTable {
  std::vector<std::int64_t> id;
  std::vector<double> radius;   ///< m
  std::vector<double> density;  ///< kg/m^3
  std::vector<int> material;    ///< index into material_names
  std::vector<std::string> material_names;
  std::vector<std::int32_t> clump{};  ///< number of its clump, -1: none; empty in a bed without
  std::vector<double> volume{};       ///< m^3 that a sphere stands for, of a clump's its share; empty without clumps
  std::vector<dem::Vec3> at_rest{};   ///< m; of a moving bed
  double period = 0;                  ///< m
  bool repeats() const { return !at_rest.empty(); }
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
  bool wall = false;  ///< of the container, that goes with a moving bed
};

/// A number that every frame carries: name and unit.
struct FrameValue {
  std::string name, unit;
};

/// Numbers of one kind on the cells of a grid, `columns` (1 or 3) of each.
struct FrameField {
  std::string name, unit;
  std::size_t columns = 1;
  std::vector<double> values;
};

/// Contacts that carry a force, as lines: from the centre of a sphere to that of the other, or to the point on a
/// surface.
struct ContactLines {
  std::vector<dem::Vec3> ends;    ///< two of each
  std::vector<std::int64_t> ids;  ///< two of each; the second is -1 at a surface
  std::vector<FrameField> fields;
};

/// One moment. Spans are in rising particle id; those of columns that are not selected may be empty.
struct Frame {
  double time = 0;  ///< s
  long step = 0;
  std::optional<std::span<const std::int64_t>> id;  ///< who is left; left out: everybody in the particle table
  std::span<const dem::Vec3> position, velocity, spin, force, torque;
  std::span<const int> contacts;
  std::span<const int> bonds{};  ///< empty where no law has any
  std::span<const dem::Pose>
      surfaces;  ///< one per surface of the list, in its order; of fixed and deforming surfaces it is not read
  std::span<const std::vector<dem::Vec3>> deformed{};  ///< vertices in world axes, one list per deforming surface
  std::span<const double> values{};                    ///< as RunOptions::values; may be empty
  const ContactLines* contact_forces = nullptr;
  std::span<const std::vector<FrameField>> loads{};  ///< on triangles, by surface; empty: on none
  std::optional<std::array<double, 2>> window{};     ///< x of its ends, m; of a moving bed
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
  int compression = 1;  ///< gzip level 0..9
  std::string title;
  std::vector<FrameValue> values{};

  static std::set<std::string> all_columns();  ///< position velocity spin force torque contacts
};

/// Which frames are on the disk: of each the number of the first frame in its file.
struct WrittenFrames {
  std::vector<std::int64_t> file_of;
};

/// Writes DIR/frames/000000.h5, 000001.h5, ..., DIR/run.h5 and DIR/run.xdmf.
///
/// HDF5 has no journal: whoever writes into a file can lose all of it when the power goes. So a file that is complete
/// is never opened again. Frames go into files of their own, which are written under another name, forced to the disk
/// and renamed; what frames share lies in frames/static.h5. run.h5 holds links only, /frames/000000 and so on, so that
/// any reader of HDF5 finds all of a run under one name, and is written anew for each frame in the same way, as is the
/// XDMF. A frame that either of them names is on the disk. Alternatives that lost: one file with ordered writes stands
/// a kill but no cut of the power (1 of 10 then does not open); SWMR mode leaves a mark that readers refuse after a
/// kill, and forces nothing to the disk (docs/reliability.md has the cost of each).
///
/// Waiting for the disk takes a twentieth of the time at most: frames that come faster share a file, named by its
/// first frame, and appear together, some ten times as late as the disk is slow. publish() makes them appear now.
class RunWriter {
 public:
  /// Throws DiskFault, as do all that write.
  /// @param go_on what an earlier writer into this directory kept: its frames stay, later ones go
  RunWriter(const std::filesystem::path& directory, ParticleTable particles, std::vector<OutputSurface> surfaces,
            RunOptions options, const WrittenFrames& go_on = {});
  ~RunWriter();
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  void write(const Frame& frame);
  /// The table of all bonds that broke, /broken bonds: time s, ids, position m, energy J, mode 0 tension or 1 shear.
  /// To be called once, at the end; nothing is written for none.
  void write_broken_bonds(std::span<const dem::BrokenBond> broken);
  long frames() const;
  const ParticleTable& particles() const;
  /// All frames so far are on the disk and named when this returns. Returns what a later writer can go on from.
  WrittenFrames publish();
  /// The same, for the last time. The destructor does so too, but cannot report.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace subsoil::app
