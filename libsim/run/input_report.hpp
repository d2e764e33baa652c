#pragma once
#include <string>
#include <vector>

#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// What is odd about a scenario though it can be run; `check` and `run` report it: STL files that were fixed, densities
/// that no soil has, or of a saved bed that are not its materials', a container that its bed hardly covers, and
/// materials of the library whose spheres have another radius than they were measured with. `file` and `sets` as the
/// scenario was read; `text`: from there, and `file` is its name.
std::vector<std::string> input_warnings(const Loaded& loaded, const World& world, const std::string& file,
                                        const std::vector<std::string>& sets, const std::string* text = nullptr);

}  // namespace subsoil::sim
