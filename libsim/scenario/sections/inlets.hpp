#pragma once
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "libsim/scenario/sections/clumps.hpp"
#include "libsim/scenario/sections/placement.hpp"
#include "libsim/scenario/sections/radius.hpp"

/// Spheres and clumps that are poured in during the run.
namespace subsoil::sim {

struct InletDisk {
  Vec3 at{required, required, required};  // centre
  Vec3 normal{0, 1, 0};
  double radius = required;
};
void describe(Fields& v, InletDisk& d);

struct InletSection {
  std::string name;
  std::optional<Box> box;
  std::optional<InletDisk> disk;      // in place of the box
  std::optional<double> mass_rate;    // `rate`, kg/s, or
  std::optional<double> number_rate;  // `rate`, 1/s
  std::string material;               // of the bed unless given
  RadiusDistribution radius;          // of the bed unless given
  ShareOf shares = ShareOf::number;
  std::vector<ClumpShare> clumps;  // among the grains; of the bed unless these or a radius are given
  double from = 0, until = std::numeric_limits<double>::infinity();  // s
  Vec3 velocity{};                                                   // m/s
  long seed = 1;
};
void describe(Fields& v, InletSection& i);

struct Checks;
struct Scenario;
struct BedSection;
void check_inlets(Checks& checks, const Scenario& s);
/// What its grains are of: its own, or the bed's; empty: neither is given.
std::string material_of(const InletSection& inlet, const std::optional<BedSection>& bed);
bool has_own_radius(const InletSection& inlet);
/// Which clumps are among its grains: its own, or the bed's where neither these nor a radius are given.
const std::vector<ClumpShare>& clumps_of(const InletSection& inlet, const std::optional<BedSection>& bed);

}  // namespace subsoil::sim
