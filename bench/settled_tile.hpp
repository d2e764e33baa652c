#pragma once
#include <string>
#include <vector>

#include "libdem/base/vec3.hpp"
#include "libdem/law_list.hpp"
#include "libdem/laws/law_table.hpp"

/// A settled bed for the benchmarks, of any length and width, without settling it anew.
///
/// One block of 13,000 spheres, nineteen layers, is settled without friction between a floor and four walls, then
/// mirrored in its walls as often as wanted. A sphere that overlaps a wall by delta meets its image with overlap
/// 2 delta; a wall whose force at delta is the spheres' at 2 delta (twice the stiffness, half the distances) leaves
/// every block in the equilibrium that it settled in. Without friction, because positions alone are kept: springs of
/// tangential history start from zero.
namespace subsoil::bench {

inline constexpr double kRadius = 0.01;    // m
inline constexpr double kDensity = 1800;   // kg/m3
inline constexpr double kStiffness = 1e5;  // N/m, of the linear law between spheres
inline constexpr std::size_t kTileSpheres = 13000;

/// The block: side in x and z, m, and centres of the spheres in m, x and z in (0, side), y above the floor at 0.
struct Tile {
  double side = 0;
  std::vector<dem::Vec3> centres;

  /// Mirrored to `along` blocks in x by `across` in z.
  std::vector<dem::Vec3> mirrored(int along, int across) const;
};

/// Table of a law between spheres (material 0) and its like between a sphere and a mirror (material 1). Throws
/// std::invalid_argument for a law that no benchmark uses.
dem::LawTable with_mirror(const dem::GivenLaw& law);

/// The block that rests under `law` (without its friction), read from `file`, a table as scenarios read it too
/// (`bed: {fill: file}`): x [m],y [m],z [m],radius [m]. Where there is none it is settled and the file written. Throws
/// std::runtime_error for a file that is no such table.
Tile settled_tile(const std::string& file, double side, const dem::GivenLaw& law);

}  // namespace subsoil::bench
