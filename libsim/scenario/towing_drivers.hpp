#pragma once
#include <string>
#include <vector>

#include "libmbd/drivers/motion.hpp"
#include "libsim/scenario/sections/machine.hpp"

namespace subsoil::sim {

/// A driver of the x of a body, which tows the machine.
struct TowingDriver {
  std::string name;
  const mbd::Motion* motion;  ///< of the machine's section
};
std::vector<TowingDriver> towing_drivers(const MachineSection& machine);

}  // namespace subsoil::sim
