#pragma once
#include <string>
#include <vector>

#include "libsim/keys/fields.hpp"

namespace subsoil::sim {

/// Points [m] of a CSV file whose header names its two columns with the unit of each, in any order: `x [mm], y [cm]`.
/// Lines that begin with # are left out. Throws a Refusal with file, line, value, rule and cure.
std::vector<Vec2> points_of_file(const std::string& file);

}  // namespace subsoil::sim
