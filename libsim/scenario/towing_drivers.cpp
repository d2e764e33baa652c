#include "libsim/scenario/towing_drivers.hpp"

#include "libmbd/elements.hpp"

namespace subsoil::sim {

std::vector<TowingDriver> towing_drivers(const MachineSection& machine) {
  std::vector<TowingDriver> out;
  for (const NamedDriver& d : machine.drivers)
    if (const auto* x = d.element.get_if<mbd::CoordinateDriver>(); x != nullptr && x->coordinate == mbd::Coordinate::x)
      out.push_back({d.name, &x->motion});
  return out;
}

}  // namespace subsoil::sim
