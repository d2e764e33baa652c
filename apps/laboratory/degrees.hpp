#pragma once
#include <numbers>

namespace subsoil::app {

inline constexpr double degrees = 180 / std::numbers::pi;  ///< of a radian

}  // namespace subsoil::app
