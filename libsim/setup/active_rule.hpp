#pragma once
#include "libdem/bed.hpp"
#include "libsim/scenario/sections/soil.hpp"

namespace subsoil::sim {

/// `soil.active` as the bed takes it.
inline dem::ActiveRule active_rule(const Active& a) { return {a.within, a.below.value_or(0)}; }

}  // namespace subsoil::sim
