#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "libsim/document/units.hpp"

namespace subsoil::sim {

/// The files of the database of units, the main one first.
std::vector<std::filesystem::path> unit_database();
/// Where the main file is, from now on: for a library in another's process, before any unit is read.
void use_unit_database(const std::string& file);
/// Names that are known without it, and the unit of a name by it: for the test that compares both.
std::vector<std::string> units_without_database();
Unit unit_by_database(const std::string& name);

}  // namespace subsoil::sim
