#pragma once
#include <cmath>
#include <numbers>

namespace subsoil::dem {

/// Normal damping ratio that a linear spring-dashpot needs for restitution e: beta = -ln e/sqrt(pi^2 + ln^2 e), F
/// unclipped until the overlap is zero again; Hertz with Tsuji's damping needs the same number. e = 0 takes 1.
inline double damping_ratio(double restitution) {
  if (restitution <= 0) return 1;
  const double log_e = std::log(restitution);
  return -log_e / std::sqrt(std::numbers::pi * std::numbers::pi + log_e * log_e);
}

}  // namespace subsoil::dem
