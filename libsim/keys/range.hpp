#pragma once
#include "libdem/base/range.hpp"

namespace subsoil::sim {

using dem::Range;

}  // namespace subsoil::sim
