#pragma once
#include <limits>

namespace subsoil::sim {

inline constexpr double required = std::numeric_limits<double>::quiet_NaN();  ///< the file must state it
inline constexpr double unlimited = std::numeric_limits<double>::infinity();

}  // namespace subsoil::sim
