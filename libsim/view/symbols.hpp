#pragma once
#include <functional>
#include <string>

#include "libsim/base/json.hpp"
#include "libsim/setup/sketch.hpp"

/// Symbols of a kinematic sketch for joints and forces, beside the solids that the sketch has of them.
namespace subsoil::sim {

/// Number of the thing at a path of the scenario.
using ThingOf = std::function<int(const std::string& path)>;

/// Symbols of all joints and forces; their keys stand in page/types.d.ts. A new type of either needs a symbol here to
/// compile.
Json element_symbols(const Scenario& scenario, const Sketch& sketch, const ThingOf& thing_of);

/// Where the first value of a force acts, and the sense in which it is positive, as the arrow of a monitor; null: the
/// value has no direction in the plane.
Json positive_sense(const Force& force, const Sketch& sketch);

}  // namespace subsoil::sim
