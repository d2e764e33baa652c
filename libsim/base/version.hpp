#pragma once
#include <string>

namespace subsoil::sim {

/// "0.1.0"
std::string version();

}  // namespace subsoil::sim
