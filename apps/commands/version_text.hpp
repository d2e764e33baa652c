#pragma once
#include <string>

namespace subsoil::sim {

/// Version, build type, compiler, instruction set in use and libraries with their versions, a line each.
std::string version_text();

}  // namespace subsoil::sim
