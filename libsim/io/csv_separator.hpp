#pragma once
#include <string>
#include <string_view>

namespace subsoil::sim::csv {

/// Of a first line whose fields are separated by something else: "has its fields separated by `;`: ..."; empty where
/// they are not. Programs in languages with decimal commas write `;`.
std::string other_separator(std::string_view line);

}  // namespace subsoil::sim::csv
