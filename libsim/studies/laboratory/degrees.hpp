#pragma once
#include <numbers>

namespace subsoil::sim {

inline constexpr double degrees = 180 / std::numbers::pi;  ///< of a radian

}  // namespace subsoil::sim
