#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/base/vec3.hpp"

/// Beds kept between runs, and particle lists that a user writes by hand or by script.
namespace subsoil::sim {

/// A clump of a saved bed: its shape by name, and where it is.
struct BedClump {
  std::string shape;
  std::int64_t first = 0;    ///< id of its first sphere in the table; the others follow
  dem::Vec3 position;        ///< of the centre of mass, m
  dem::Quaternion attitude;  ///< principal axes to world axes
  dem::Vec3 velocity, spin;  ///< m/s, rad/s
  void archive(Archive& a) {
    a("shape", shape)("first", first)("position", position)("attitude", attitude);
    a("velocity", velocity)("spin", spin);
  }
};

struct BedTable {
  std::vector<std::int64_t> id;
  std::vector<dem::Vec3> position;        ///< m
  std::vector<double> radius;             ///< m
  std::vector<double> density;            ///< kg/m^3; NaN where a list leaves it to the material
  std::vector<std::string> material;      ///< name; empty where a list leaves it to the scenario
  std::vector<dem::Vec3> velocity, spin;  ///< m/s, rad/s
  /// m, height of the mean surface to which bed and container were shifted (`soil.surface`) by the run that saved it.
  /// Positions are those before: the bed lies on the floor of its container.
  std::optional<double> surface{};
  std::vector<BedClump> clumps{};  ///< in rising id of their spheres, which stand in the table, too; not in a CSV

  std::size_t size() const { return id.size(); }
};

/// Factor from a unit written by the user to the SI unit asked for; throws std::invalid_argument when there is none.
using UnitFactor = std::function<double(std::string_view unit, std::string_view si)>;

/// By suffix: .h5 (double precision) or .csv. The file appears complete or not at all.
void save_bed(const std::filesystem::path& path, const BedTable& bed);

/// By suffix. A CSV has a first line with column names and units, in any order:
///     id,x [m],y [m],z [m],radius [mm],density [kg/m^3],material,vx [m/s],vy [m/s],vz [m/s],wx [rad/s],wy [rad/s],wz
///     [rad/s]
/// x, y, z and radius must stand; id defaults to 1, 2, ..., velocities to zero. Without `factor` only SI units
/// are read. Refusals (std::invalid_argument) name file, line, column, value and rule.
BedTable load_bed(const std::filesystem::path& path, const UnitFactor& factor = {});

}  // namespace subsoil::sim
