#pragma once
#include "libdem/base/archive.hpp"

namespace subsoil::sim {

/// Terms of the energy balance when the run began, J.
struct EnergyStart {
  double bed = 0, bed_gravity = 0, machine_potential = 0;
  void archive(Archive& a) { a("bed", bed)("bed gravity", bed_gravity)("machine potential", machine_potential); }
};

}  // namespace subsoil::sim
