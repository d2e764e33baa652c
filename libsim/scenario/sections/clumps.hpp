#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libsim/scenario/sections/placement.hpp"

/// Grains made of several spheres.
namespace subsoil::sim {

struct ClumpSphere {
  Vec3 at{required, required, required};
  double radius = required;
};
void describe(Fields& v, ClumpSphere& s);

/// A shape of clumps. Mass, centre and inertia are those of the union of its spheres unless given.
struct ClumpSection {
  std::string name;
  std::vector<ClumpSphere> spheres;
  double scale = 1;
  std::optional<double> density;  // kg/m^3, of the bed's material unless given
  std::optional<double> mass;     // kg
  std::optional<Vec3> centre;     // m
  std::optional<Vec3> inertia;    // kg m^2: xx, yy, zz
  std::optional<Vec3> products;   // kg m^2: xy, yz, zx
};
void describe(Fields& v, ClumpSection& c);

/// How many of a bed's grains are of a shape.
struct ClumpShare {
  std::string shape;
  double share = 1;
};
void describe(Fields& v, ClumpShare& c);

struct PlacedClump {
  std::string shape;
  Vec3 position{required, required, required};
  Rotation rotation;
  Vec3 velocity{}, spin{};
  std::string material;  // of the bed unless given
};
void describe(Fields& v, PlacedClump& c);

struct Checks;
struct Scenario;
void check_clumps(Checks& checks, const Scenario& s);
/// Whether grains of this shape are in the bed or poured, or may be in the bed's file.
bool uses_clump(const Scenario& s, const std::string& shape);
/// Whether all grains of a bed are clumps, so that no radius of spheres is needed.
bool only_clumps(const std::vector<ClumpShare>& shares);

}  // namespace subsoil::sim
