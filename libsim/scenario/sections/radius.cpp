#include "libsim/scenario/sections/radius.hpp"

#include <algorithm>

#include "libsim/scenario/checks.hpp"

namespace subsoil::sim {

void describe(Fields& v, EqualRadius& r) {
  v.card("equal", "all spheres alike; the radius may stand directly: `radius: 10 mm`");
  v.quantity("equal", r.radius, "m", "(0, inf)", "radius of every sphere");
}

void describe(Fields& v, NormalRadius& r) {
  v.card("normal", "normal distribution, cut off, of the number or the mass of grains (`shares`)");
  v.quantity("normal", r.mean, "m", "(0, inf)", "mean radius");
  v.quantity("deviation", r.deviation, "m", "(0, inf)", "standard deviation");
  v.quantity("minimum", r.least, "m", "(0, inf)", "smaller radii are drawn again");
  v.quantity("maximum", r.largest, "m", "(0, inf)", "larger radii are drawn again");
}

void describe(Fields& v, UniformRadius& r) {
  v.card("uniform", "all radii between two values equally likely, by number or mass (`shares`)");
  v.span("uniform", r.least, r.largest, "m", "(0, inf)", "minimum and maximum radius");
}

void describe(Fields& v, TableRadius& r) {
  v.card("table", "given radii with given shares");
  v.table("table", r.radius, r.share, "m", "1", "radius and its share; the shares need not sum to one");
}

void check_distribution(Checks& checks, const std::string& path, const RadiusDistribution& radius) {
  if (const auto* n = std::get_if<NormalRadius>(&radius)) {
    if (n->least > n->mean || n->mean > n->largest || n->least >= n->largest) {
      checks.refuse(path, "must have minimum <= normal <= maximum, and minimum below maximum");
    }
  } else if (const auto* t = std::get_if<TableRadius>(&radius)) {
    double sum = 0;
    for (std::size_t i = 0; i < t->radius.size(); ++i) {
      if (t->radius[i] <= 0 || t->share[i] < 0) {
        checks.refuse(path + ".table", "must have radii above zero and shares of zero or more");
        return;
      }
      sum += t->share[i];
    }
    if (!(sum > 0)) checks.refuse(path + ".table", "must have a share above zero");
  }
}

double largest_radius(const RadiusDistribution& radius) {
  if (const auto* equal = std::get_if<EqualRadius>(&radius)) return equal->radius;
  if (const auto* normal = std::get_if<NormalRadius>(&radius)) return normal->largest;
  if (const auto* uniform = std::get_if<UniformRadius>(&radius)) return uniform->largest;
  const auto& table = std::get<TableRadius>(radius).radius;
  return *std::max_element(table.begin(), table.end());
}

}  // namespace subsoil::sim
