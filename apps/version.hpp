#pragma once
#include <string>

namespace subsoil::app {

/// "0.1.0"
std::string version();
/// Version, build type, compiler, instruction set in use and libraries with their versions, a line each.
std::string version_text();

}  // namespace subsoil::app
