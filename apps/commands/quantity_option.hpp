#pragma once
#include <string>

namespace subsoil::sim {

/// Value of an option with its unit, SI. Throws std::invalid_argument naming the option where it cannot be read, or is
/// not above zero where it must be.
double quantity_option(const char* option, const std::string& text, const char* unit, bool positive);

}  // namespace subsoil::sim
