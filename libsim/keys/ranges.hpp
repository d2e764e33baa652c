#pragma once
#include <string>
#include <vector>

namespace subsoil::sim {

/// How the range of a parameter is filled: evenly in the value or in its logarithm.
enum class Scale { linear, log };

/// Value at the share u of a range, 0 at `least`, 1 at `largest`.
double value_in_range(Scale scale, double least, double largest, double u);

/// What stands between semicolons, without blanks around it.
std::vector<std::string> split_at_semicolons(const std::string& text);

}  // namespace subsoil::sim
