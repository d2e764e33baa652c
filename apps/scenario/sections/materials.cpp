#include "apps/scenario/sections/materials.hpp"

#include <algorithm>
#include <cmath>

namespace subsoil::app {

double combined(CombinationRule rule, double a, double b) {
  switch (rule) {
    case CombinationRule::arithmetic_mean:
      return 0.5 * (a + b);
    case CombinationRule::geometric_mean:
      return std::sqrt(a * b);
    case CombinationRule::harmonic_mean:
      return a + b > 0 ? 2 * a * b / (a + b) : 0;
    case CombinationRule::minimum:
      return std::min(a, b);
    case CombinationRule::maximum:
      return std::max(a, b);
  }
  return a;
}

void describe(Fields& v, Material& m) {
  v.quantity("density", m.density, "kg/m^3", "(0, inf)", "density of the material itself, not of the bulk");
  v.quantity("young's modulus", m.young, "Pa", "(0, inf)", "needed by laws that compute their stiffness from it");
  v.quantity("poisson ratio", m.poisson, "1", "(-1, 0.5]", "needed by laws that compute their stiffness from it");
  v.quantity("yield strength", m.yield, "Pa", "(0, inf)",
             "needed by laws that leave theirs out; of two bodies the one of less strength yields");
  for (const Combinable& c : combinables) v.quantity(c.key, m.*c.value, c.unit, c.range, c.meaning);
}

}  // namespace subsoil::app
