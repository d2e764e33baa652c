#pragma once
#include "libsim/keys/fields.hpp"

namespace subsoil::sim {

/// Beyond these the run stops.
struct Limits {
  double overlap = 0.5;      // share of the radius
  double speed = 50;         // m/s
  double energy = 0.1;       // share of the machine's energy by which its balance may be off
  double soil_energy = 0.5;  // likewise of the soil's energy moved
};
void describe(Fields& v, Limits& l);

}  // namespace subsoil::sim
