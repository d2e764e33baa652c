#pragma once
#include <variant>

#include "libdem/impact/energy_equivalent.hpp"
#include "libdem/impact/hertz.hpp"
#include "libdem/impact/hunt_crossley.hpp"
#include "libdem/impact/hysteretic.hpp"
#include "libdem/impact/jackson_green.hpp"
#include "libdem/impact/jkr.hpp"
#include "libdem/impact/thornton.hpp"

/// The list of impact models: a new one is its own file and one entry here. Each answers
///   double restitution_at(const Pair&, double speed) const
///   Event strike(const Pair&, double speed, int samples) const
/// and throws std::invalid_argument with the cure when the pair lacks what it needs.
namespace subsoil::dem::impact {

using Model = std::variant<HuntCrossleyModel, Hertz, Hysteretic, EnergyEquivalent, Thornton, JacksonGreen, Jkr>;

}  // namespace subsoil::dem::impact
