#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace subsoil::sim {

/// The files of the database of units, the main one first.
std::vector<std::filesystem::path> unit_database();
/// Where the main file is, from now on: for a library in another's process, before any unit is read.
void use_unit_database(const std::string& file);

}  // namespace subsoil::sim
