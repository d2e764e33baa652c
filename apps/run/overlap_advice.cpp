#include "apps/run/overlap_advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "apps/scenario/given_law.hpp"
#include "libdem/laws/linear.hpp"
#include "libdem/laws/wet.hpp"

namespace subsoil::app {
namespace {

/// The deepest contact of a sphere.
struct Deepest {
  double overlap = 0;  ///< m
  int material = -1;   ///< of the other one
  std::string other;
};

Deepest deepest_contact(const dem::Sphere& s, const World& world) {
  Deepest out;
  for (const dem::Sphere& p : world.bed->spheres())
    if (const double d = s.r + p.r - dem::norm(s.x - p.x); p.id != s.id && d > out.overlap)
      out = {d, p.material, fmt::format("sphere {}", p.id)};
  for (int i = 0; i < world.bed->boundary_count(); ++i) {
    const dem::Boundary& b = world.bed->boundary(i);
    if (!b.active) continue;
    const Vec3 c = b.pose.to_local(s.x);
    std::vector<std::uint32_t> near;
    dem::candidates(b.shape, c, 2 * s.r, near);
    dem::SurfaceContact touch[1];
    if (near.empty() || dem::contacts(b.shape, c, 2 * s.r, near, touch, 1) == 0) continue;
    if (const double d = s.r - touch[0].distance; d > out.overlap) out = {d, b.material, "`" + b.name + "`"};
  }
  return out;
}

struct Stiffness {
  const char* key;
  double value;  ///< N/m
};

std::optional<Stiffness> stiffness_of(const GivenLaw& law) {
  if (const auto* linear = law.get_if<dem::Linear>()) return Stiffness{"k_n", linear->k_n};
  if (const auto* wet = law.get_if<dem::Wet>()) return Stiffness{"K_X", wet->K_X};
  return {};
}

}  // namespace

std::string overlap_advice(const std::string& fault, const World& world, const Scenario& scenario) {
  unsigned id = 0;
  const std::size_t at = fault.find("sphere ");
  if (!world.bed || fault.find("overlaps by") == std::string::npos || at == std::string::npos ||
      std::sscanf(fault.c_str() + at, "sphere %u", &id) != 1)
    return {};
  const auto spheres = world.bed->spheres();
  const auto sphere = std::find_if(spheres.begin(), spheres.end(), [&](const dem::Sphere& s) { return s.id == id; });
  if (sphere == spheres.end()) return {};
  const Deepest deepest = deepest_contact(*sphere, world);
  if (deepest.material < 0) return {};
  const int law = world.laws.of(sphere->material, deepest.material);
  if (law < 0) return {};
  const Contact& contact = scenario.contacts[static_cast<std::size_t>(law)];
  const std::string name = "contacts." + contact.between[0] + "-" + contact.between[1];
  std::string text = fmt::format("sphere {} is pressed {:.3g} mm into {}", id, deepest.overlap * 1e3, deepest.other);
  if (const auto k = stiffness_of(contact.law))
    return text + fmt::format(
                      " with {:.3g} N by {}.{} = {:.4g} kN/m; {:.4g} kN/m halve the overlap under this force, at 0.7 "
                      "times the step: --set \"{}.{}={:.4g} kN/m\"; or move slower, or less deep",
                      k->value * deepest.overlap, name, k->key, k->value * 1e-3, 2e-3 * k->value, name, k->key,
                      2e-3 * k->value);
  return text + fmt::format(
                    " by the law {}: make it stiffer, or move slower, "
                    "or less deep",
                    name);
}

}  // namespace subsoil::app
