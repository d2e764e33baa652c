#pragma once
#include <string>
#include <variant>
#include <vector>

#include "libsim/keys/fields.hpp"
#include "libsim/scenario/sections/defaults.hpp"

/// Radii of spheres: one, or a distribution.
namespace subsoil::sim {

struct EqualRadius {
  static constexpr bool stands_alone = true;  ///< `radius: 10 mm`
  double radius = required;
};
void describe(Fields& v, EqualRadius& r);

struct NormalRadius {  // values outside [`least`, `largest`] are drawn again
  double mean = required, deviation = required, least = required, largest = required;
};
void describe(Fields& v, NormalRadius& r);

struct UniformRadius {
  double least = required, largest = required;
};
void describe(Fields& v, UniformRadius& r);

struct TableRadius {
  std::vector<double> radius, share;  // shares need not sum to one
};
void describe(Fields& v, TableRadius& r);

using RadiusDistribution = std::variant<EqualRadius, NormalRadius, UniformRadius, TableRadius>;
enum class ShareOf { number, mass };

struct Checks;
void check_distribution(Checks& checks, const std::string& path, const RadiusDistribution& radius);
/// Of a normal distribution the cut-off.
double largest_radius(const RadiusDistribution& radius);

}  // namespace subsoil::sim
