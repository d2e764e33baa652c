#include "libdem/impact/energy_equivalent.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "libdem/impact/hunt_crossley.hpp"
#include "libdem/impact/jackson_green.hpp"

namespace subsoil::dem::impact {

double EnergyEquivalent::strength(const Pair& pair) const {
  const double yield = std::isnan(S_y) ? pair.yield : S_y;
  if (!(yield > 0)) throw std::invalid_argument("needs a yield strength: give S_y, or yield strength of a body");
  return yield;
}

double EnergyEquivalent::lambda(const Pair& pair, double speed) const {
  const double rho = std::isnan(density) ? pair.density : density;
  if (!(rho > 0)) throw std::invalid_argument("needs a density: give rho, or density of the first body");
  return rho * speed * speed / strength(pair);
}

double EnergyEquivalent::critical_lambda(const Pair& pair) const {
  if (!std::isnan(lambda_c)) return lambda_c;
  if (!(pair.E_eff > 0))
    throw std::invalid_argument("needs lambda_c, or young and poisson of both bodies to find it from");
  const double half = std::numbers::pi * yield_coefficient(poisson) / 2;
  return 4 / (5 * std::numbers::pi) * std::pow(half, 5) * std::pow(strength(pair) / pair.E_eff, 4);
}

double EnergyEquivalent::restitution_at(const Pair& pair, double speed) const {
  const double over = lambda(pair, speed) / critical_lambda(pair);
  const double strain = over > 1 ? A * std::expm1(B * std::log(over)) : 0;
  return 1 / std::sqrt(1 + 2 * strain);
}

Event EnergyEquivalent::strike(const Pair& pair, double speed, int samples) const {
  HuntCrossleyModel law;
  law.c = pair.hertz();
  law.restitution = restitution_at(pair, speed), law.at_speed = speed;
  return law.strike(pair, speed, samples);
}

}  // namespace subsoil::dem::impact
