#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "libsim/scenario/sections/placement.hpp"

/// Flexible fibres that are laid on a bed: straw, roots.
namespace subsoil::sim {

enum class FibreOrientation { random, horizontal, x, y, z };

struct FibreSection {
  std::string name;
  std::string material;
  double length = required, diameter = required;  // m
  std::optional<long> count;                      // or
  std::optional<double> mass_per_area;            // kg/m^2 of the plan of where they begin
  FibreOrientation orientation = FibreOrientation::random;
  double scatter = 0;         // rad, of an orientation along an axis
  std::optional<Box> region;  // in which they begin; above the bed, over the container's plan unless given
  std::optional<long> seed;   // of the bed unless given
};
void describe(Fields& v, FibreSection& f);

struct Checks;
struct Scenario;
void check_fibres(Checks& checks, const Scenario& s);
/// Edges of tools and the strength of fibres against them: one acts on the other.
void check_cutting(Checks& checks, const Scenario& s);

/// Spheres in a row.
int spheres_of(const FibreSection& fibre);
/// Of the matter, a round rod as long as the row of spheres, kg. @param density of the material, kg/m3
double mass_of(const FibreSection& fibre, double density);
/// How many: as given, or as many as come nearest to the mass per area.
std::size_t count_of(const FibreSection& fibre, const Scenario& s);
/// Spheres of all fibres together.
std::size_t fibre_spheres(const Scenario& s);

}  // namespace subsoil::sim
