#pragma once
#include <optional>

#include "libdem/base/archive.hpp"
#include "libdem/base/vec3.hpp"

namespace subsoil::sim {

/// Terms of the energy balance when the run began, J. Works, losses and what gravity gives count from there on.
struct EnergyStart {
  double bed = 0, bed_gravity = 0, machine_potential = 0;
  double there = 0;                    ///< kinetic and stored, of bed and machine
  std::optional<dem::Vec3> gravity{};  ///< that the potentials are of, m/s^2; none: of a state that has not kept it
  void archive(Archive& a) {
    a("bed", bed)("bed gravity", bed_gravity)("machine potential", machine_potential);
    if (!a.reads() || a.has("gravity")) a("gravity", gravity);
    if (!a.reads() || a.has("there")) a("there", there);
  }
};

}  // namespace subsoil::sim
