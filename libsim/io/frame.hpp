#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "libdem/bed.hpp"

/// What frames of a run hold.
namespace subsoil::sim {

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
  std::vector<std::int32_t> fibre{};  ///< number of its fibre, -1: of none; empty in a bed without
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

/// A moment between the last two instants of which an engine has the spheres: `share` of the step of `step` s before
/// the later.
struct Between {
  double step = 0, share = 0;
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
  Between between{};  ///< where the spheres are, if each process writes its own (frame_parts.hpp)
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

  static std::set<std::string> all_columns();  ///< `position velocity spin force torque contacts`
};

}  // namespace subsoil::sim
