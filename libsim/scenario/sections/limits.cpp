#include "libsim/scenario/sections/limits.hpp"

namespace subsoil::sim {

void describe(Fields& v, Limits& l) {
  v.quantity("overlap", l.overlap, "1", "(0, 2]", "share of a radius; a deeper contact stops the run");
  v.quantity("speed", l.speed, "m/s", "(0, inf)", "a faster sphere stops the run");
  v.quantity("soil energy", l.soil_energy, "1", "(0, inf)",
             "soil whose energy balance is off by a larger share of the energy there or moved stops the run; 0.05 is "
             "warned of");
  v.quantity("energy", l.energy, "1", "(0, inf)",
             "a machine whose energy balance is off by a larger share of the energy there or moved stops the run");
}

}  // namespace subsoil::sim
