#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libdem/particles/particles.hpp"
#include "libsim/scenario/sections/boundaries.hpp"
#include "libsim/scenario/sections/contacts.hpp"
#include "libsim/scenario/sections/limits.hpp"
#include "libsim/scenario/sections/machine.hpp"
#include "libsim/scenario/sections/materials.hpp"
#include "libsim/scenario/sections/output.hpp"
#include "libsim/scenario/sections/soil.hpp"
#include "libsim/scenario/sections/time.hpp"

/// What a scenario file states, as plain structs in SI units, before anything is built from it. A section that the file
/// leaves out is an empty optional or list: soil only and machine only are scenarios. The file of a section in
/// `sections/` holds its struct, its keys (units, ranges, defaults, meanings, once for reader, printer, `explain` and
/// docs) and its checks.
namespace subsoil::sim {

/// What is done with the machine; all but dynamics are for machines without soil.
enum class Analysis { dynamics, kinematics, equilibrium, modes, assembly };
inline constexpr std::array<const char*, 5> analysis_names{"dynamics", "kinematics", "equilibrium", "modes",
                                                           "assembly"};

/// What steps the spheres: our own bed, or LIGGGHTS on many processes (docs/reference/many-nodes.md).
enum class SoilEngine { subsoil, liggghts };

struct Scenario {
  long version = 1;
  std::string title;
  Analysis analysis = Analysis::dynamics;
  Vec3 gravity{0, -9.81, 0};
  std::vector<Material> materials;
  std::vector<Contact> contacts;
  std::optional<Soil> soil;
  std::vector<BoundarySection> boundaries;
  std::optional<MachineSection> machine;
  Time time;
  Output output;
  Limits limits;
  SoilEngine engine = SoilEngine::subsoil;
  std::string simd = "auto";
  dem::Precision precision = dem::Precision::doubles;
  std::map<std::string, std::uint32_t> contents;  ///< of the files that were read with it: CRC-32 by path

  /// Without soil a row of the series holds everything at its instant, in full precision.
  bool has_bed() const { return soil.has_value() || !boundaries.empty(); }
  bool instant_forces() const {
    return output.forces == ForceColumns::instant || (output.forces == ForceColumns::automatic && !has_bed());
  }
  /// Analyses that follow the machine over time.
  bool runs_in_time() const { return analysis == Analysis::dynamics || analysis == Analysis::kinematics; }
};
void describe(Fields& v, Scenario& s);

}  // namespace subsoil::sim
