#include "libsim/report/draft_models.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace subsoil::sim {
namespace {

double cot(double angle) { return 1 / std::tan(angle); }

/// The factors at a rupture angle.
struct Factors {
  double weight = 0, surcharge = 0, cohesion = 0, adhesion = 0;
};

Factors factors(const WedgeSoil& soil, double width, double depth, double rake, double rupture) {
  const double k = cot(rake) + cot(rupture);
  const double under_root = cot(rupture) * cot(rupture) + 2 * cot(rake) * cot(rupture);
  const double aside = depth * std::sqrt(std::fmax(0.0, under_root)) / width;  // s / w
  const double m =
      std::cos(rake + soil.wall_friction) + std::sin(rake + soil.wall_friction) * cot(rupture + soil.friction);
  if (!(m > 0) || !(k > 0)) return {std::numeric_limits<double>::infinity(), 0, 0, 0};
  const double c = cot(rupture + soil.friction);
  return {0.5 * k * (1 + 2 * aside / 3) / m, k * (1 + aside) / m, (1 + cot(rupture) * c) * (1 + aside) / m,
          (1 - cot(rake) * c) / m};
}

}  // namespace

Band asabe_subsoiler(double depth, double speed) {
  const double s = 3.6 * speed, per_tool = (226 + 1.8 * s * s) * 100 * depth;
  return {0.5 * 0.45 * per_tool, 1.5 * per_tool};
}

double mckyes_ali_rupture(const WedgeSoil& soil, double width, double depth, double rake) {
  constexpr int steps = 2000;
  double best = std::numeric_limits<double>::quiet_NaN(), least = std::numeric_limits<double>::infinity();
  for (int i = 1; i < steps; ++i) {
    const double rupture = 0.5 * std::numbers::pi * i / steps;
    if (rupture + soil.friction >= std::numbers::pi) break;
    const double weight = factors(soil, width, depth, rake, rupture).weight;
    if (weight < least) least = weight, best = rupture;
  }
  return best;
}

double mckyes_ali(const WedgeSoil& soil, double width, double depth, double rake) {
  const double rupture = mckyes_ali_rupture(soil, width, depth, rake);
  if (!std::isfinite(rupture) || rake + soil.wall_friction >= std::numbers::pi)
    return std::numeric_limits<double>::quiet_NaN();
  const Factors n = factors(soil, width, depth, rake, rupture);
  const double passive =
      width * (soil.density * soil.gravity * depth * depth * n.weight + soil.cohesion * depth * n.cohesion +
               soil.surcharge * depth * n.surcharge + soil.adhesion * depth * n.adhesion);
  return passive * std::sin(rake + soil.wall_friction) + soil.adhesion * depth * width * cot(rake);
}

}  // namespace subsoil::sim
