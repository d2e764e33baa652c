#include "libsim/setup/inlets.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libdem/neighbours/periodic_search.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/setup/laws.hpp"
#include "libsim/setup/soil.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {
namespace {

/// Between times at which grains come: lists are built again then, which costs as much as some steps.
constexpr double kIntervalSteps = 50;

std::variant<dem::Bounds, dem::InletDisk> region_of(const InletSection& i) {
  if (i.box) return dem::Bounds{i.box->at, i.box->at + i.box->size};
  return dem::InletDisk{i.disk->at, i.disk->normal, i.disk->radius};
}

/// Numbers that a grain of any inlet needs at most: one for each of its spheres.
std::uint32_t numbers_per_grain(const Scenario& s, const dem::Bed& bed) {
  std::size_t most = 1;
  for (const InletSection& i : s.soil->inlets)
    for (const dem::ClumpPart& part : parts_of(clumps_of(i, s.soil->bed), s, bed))
      most = std::max(most, bed.clump_shapes()[static_cast<std::size_t>(part.shape)].members.size());
  return static_cast<std::uint32_t>(most);
}

}  // namespace

dem::RadiusDistribution sizes_of(const InletSection& inlet, const Scenario& s) {
  return sizes_of(has_own_radius(inlet) ? inlet.radius : s.soil->bed->radius);
}

void add_inlets(World& world, const Loaded& loaded) {
  const Scenario& s = loaded.scenario;
  if (!s.soil) return;
  std::uint32_t next = 0;
  for (const dem::Sphere& one : world.bed->spheres()) next = std::max(next, one.id + 1);
  const auto count = static_cast<std::uint32_t>(s.soil->inlets.size());
  const std::uint32_t numbers = numbers_per_grain(s, *world.bed);
  for (std::uint32_t k = 0; k < count; ++k) {
    const InletSection& i = s.soil->inlets[k];
    const ShareOf shares = has_own_radius(i) ? i.shares : s.soil->bed->shares;
    const int material = material_index(s, material_of(i, s.soil->bed));
    dem::InletPlan plan;
    plan.region = region_of(i);
    plan.clumps = parts_of(clumps_of(i, s.soil->bed), s, *world.bed);
    if (!plan.clumps.empty()) plan.shapes = world.bed->clump_shapes();
    // Where there are no spheres, whatever the clumps are made of.
    plan.radius = only_clumps(clumps_of(i, s.soil->bed))
                      ? dem::EqualRadius{world.bed->clump_shapes().front().members.front().radius}
                      : sizes_of(i, s);
    plan.shares = shares == ShareOf::mass ? dem::ShareOf::mass : dem::ShareOf::number;
    plan.of = {s.materials[static_cast<std::size_t>(material)].density, material};
    plan.seed = static_cast<std::uint64_t>(i.seed) + 1000003 * k;  // alike inlets pour different spheres
    plan.rate = i.mass_rate ? *i.mass_rate : *i.number_rate;
    plan.counts = !i.mass_rate;
    plan.from = i.from, plan.until = i.until;
    plan.velocity = i.velocity;
    plan.interval = kIntervalSteps * world.step.soil_step;
    plan.first_id = next + k * numbers, plan.id_step = count * numbers;
    try {
      const dem::PeriodicCell& cell = world.bed->options().periodic;
      const double reach = 2 * dem::largest_radius(plan.radius);
      dem::require_period(cell, reach);
      for (const dem::ClumpPart& part : plan.clumps)
        dem::require_period_of_clumps(cell, reach + dem::widest_gap(plan.shapes[static_cast<std::size_t>(part.shape)]));
      world.inlets.push_back({i.name, dem::Inlet(std::move(plan))});
    } catch (const std::invalid_argument& error) {
      throw ScenarioError(loaded.where("soil.inlets." + i.name) + ": " + error.what());
    }
  }
}

bool has_clumps(const World& world) {
  return !world.bed->clumps().empty() || std::any_of(world.inlets.begin(), world.inlets.end(), [](const PouredSoil& i) {
    return !i.inlet.plan().clumps.empty();
  });
}

}  // namespace subsoil::sim
