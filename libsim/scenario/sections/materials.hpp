#pragma once
#include <array>
#include <optional>
#include <string>

#include "libsim/keys/fields.hpp"
#include "libsim/scenario/sections/defaults.hpp"

/// What soil, tools and walls are made of.
namespace subsoil::sim {

struct Material {
  std::string name;
  double density = required;    // kg/m^3
  std::optional<double> young;  // Pa, for laws that compute their stiffness from it
  std::optional<double> poisson;
  std::optional<double> yield{};  // Pa, for laws whose bodies yield
  // What a pair's value may be combined from, by a rule that its entry names.
  std::optional<double> restitution{}, mu{}, mu_d{}, mu_r{}, mu_t{}, adhesion{};
};
void describe(Fields& v, Material& m);

enum class CombinationRule { arithmetic_mean, geometric_mean, harmonic_mean, minimum, maximum };
inline constexpr std::array<const char*, 5> rule_words{"arithmetic-mean", "geometric-mean", "harmonic-mean", "minimum",
                                                       "maximum"};
double combined(CombinationRule rule, double a, double b);

/// A property of materials that the entry of a pair may combine from both: the law's own key, unit and range.
struct Combinable {
  const char* key;
  std::optional<double> Material::*value;
  const char* unit;
  Range range;
  const char* meaning;
};
inline constexpr std::array<Combinable, 6> combinables{
    {{"restitution", &Material::restitution, "1", "(0, 1]", "for pairs that `combine` it"},
     {"mu", &Material::mu, "1", "[0, inf)", "static friction coefficient, for pairs that `combine` it"},
     {"mu_d", &Material::mu_d, "1", "[0, inf)", "sliding friction coefficient, for pairs that `combine` it"},
     {"mu_r", &Material::mu_r, "1", "[0, inf)", "rolling friction coefficient, for pairs that `combine` it"},
     {"mu_t", &Material::mu_t, "1", "[0, inf)", "twisting friction coefficient, for pairs that `combine` it"},
     {"work of adhesion", &Material::adhesion, "J/m^2", "(0, inf)", "for pairs that `combine` it"}}};

}  // namespace subsoil::sim
