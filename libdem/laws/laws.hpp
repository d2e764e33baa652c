#pragma once
#include <variant>

#include "libdem/laws/eepa.hpp"
#include "libdem/laws/hertz_mindlin.hpp"
#include "libdem/laws/hunt_crossley.hpp"
#include "libdem/laws/hysteretic.hpp"
#include "libdem/laws/linear.hpp"
#include "libdem/laws/luding.hpp"
#include "libdem/laws/variable_restitution.hpp"
#include "libdem/laws/wet.hpp"

/// The list of contact laws: a new law is its own file and one word here. Reader, checker, explain, documentation and
/// the sweep all work from this list.
namespace subsoil::dem {

using Law = std::variant<Wet, Linear, HertzMindlin, HuntCrossley, Hysteretic, Luding, Eepa, VariableRestitution>;

}  // namespace subsoil::dem
