#pragma once
#include <optional>
#include <string>

namespace subsoil::sim {

/// What numbers in the unit `from` are multiplied by to be in the unit `to`; empty where the dimensions differ.
std::optional<double> unit_factor(const std::string& from, const std::string& to);

}  // namespace subsoil::sim
