#pragma once
#include <string>

namespace subsoil::sim {

/// The icon of an FMU as a PNG file of 128 by 128 pixels: spheres below a tine, or a machine's linkage above them.
std::string fmu_icon(bool with_machine);

}  // namespace subsoil::sim
