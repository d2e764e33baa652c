#include "libsim/base/version.hpp"

namespace subsoil::sim {

std::string version() { return SUBSOIL_VERSION; }

}  // namespace subsoil::sim
