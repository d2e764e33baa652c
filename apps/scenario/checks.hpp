#pragma once
#include <map>
#include <string>

#include "apps/scenario/document.hpp"
#include "apps/scenario/scenario.hpp"

namespace subsoil::app {

using Places = std::map<std::string, Place>;

/// Place of a path, or of the nearest enclosing key that stands in the file.
Place place_of(const Places& places, std::string path);

/// What no single key can know: names that must exist, pairs of materials that need a law, keys that need or exclude
/// each other. Fills Surface::body_index.
void check(Scenario& scenario, const Places& places, Problems& problems);

}  // namespace subsoil::app
