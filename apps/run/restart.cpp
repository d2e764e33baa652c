#include "apps/run/restart.hpp"

#include <cmath>

#include "apps/output/state_file.hpp"

namespace subsoil::app {
namespace {

/// 2: memory of contacts in the order of libdem/contacts/contact_memory.hpp, bonds with what they released. (Before: no
/// number.)
constexpr std::int64_t kStateFormat = 2;

}  // namespace

void save_run(const std::filesystem::path& directory, const Scenario& scenario, const World& world,
              const coupling::Simulation& simulation) {
  StateWriter out(state_path(directory, simulation.time()));
  out.put_format(kStateFormat);
  out.put_text("scenario", write_scenario(scenario));
  out.put("time", simulation.time());
  if (world.bed) {
    const dem::Bed::State bed = world.bed->save();
    out.put("bed/spheres", bed.spheres);
    out.put("bed/ids", bed.ids);
    out.put("bed/pair ids", bed.pair_ids);
    out.put("bed/pairs", bed.pairs);
    out.put("bed/surface ids", bed.surface_ids);
    out.put("bed/surfaces", bed.surfaces);
    out.put("bed/scalars", bed.scalars);
    if (!bed.calm.empty()) out.put("bed/calm", bed.calm), out.put("bed/frozen", bed.frozen);
    if (!bed.bonding.empty()) {
      out.put("bed/bonding", bed.bonding);
      out.put("bed/bond ids", bed.bond_ids);
      out.put("bed/bonds", bed.bonds);
      out.put("bed/broken ids", bed.broken_ids);
      out.put("bed/broken", bed.broken);
    }
    const SoilReport& s = world.soil;
    out.put("soil", std::vector<double>{static_cast<double>(s.spheres), s.mass, s.settled_for, s.rms_speed,
                                        s.bulk_density, s.surface_mean, s.surface_spread, s.coordination,
                                        static_cast<double>(s.carved), world.container_shift});
  }
  if (world.machine) out.put("machine", world.machine->snapshot());
  out.put("coupling", simulation.save());
  out.commit();
}

SavedRun read_run(const std::filesystem::path& file) {
  const StateReader in(file);
  in.require_format(kStateFormat,
                    {"bed/spheres", "bed/ids", "bed/pair ids", "bed/pairs", "bed/surface ids", "bed/surfaces",
                     "bed/scalars", "bed/bonding", "bed/bond ids", "bed/bonds", "bed/broken ids", "bed/broken",
                     "bed/calm", "bed/frozen", "soil", "machine", "coupling", "scenario", "time"});
  SavedRun saved;
  if (in.has("scenario")) saved.scenario = in.text("scenario"), saved.time = in.value<double>("time");
  saved.has_bed = in.has("bed/spheres");
  if (saved.has_bed) {
    saved.bed.spheres = in.get<double>("bed/spheres");
    saved.bed.ids = in.get<std::int64_t>("bed/ids");
    saved.bed.pair_ids = in.get<std::int64_t>("bed/pair ids");
    saved.bed.pairs = in.get<double>("bed/pairs");
    saved.bed.surface_ids = in.get<std::int64_t>("bed/surface ids");
    saved.bed.surfaces = in.get<double>("bed/surfaces");
    saved.bed.scalars = in.get<double>("bed/scalars");
    if (in.has("bed/calm")) {
      saved.bed.calm = in.get<std::int64_t>("bed/calm");
      saved.bed.frozen = in.get<double>("bed/frozen");
    }
    if (in.has("bed/bonding")) {
      saved.bed.bonding = in.get<double>("bed/bonding");
      saved.bed.bond_ids = in.get<std::int64_t>("bed/bond ids");
      saved.bed.bonds = in.get<double>("bed/bonds");
      saved.bed.broken_ids = in.get<std::int64_t>("bed/broken ids");
      saved.bed.broken = in.get<double>("bed/broken");
    }
    const std::vector<double> s = in.get<double>("soil");
    saved.soil = {.spheres = static_cast<std::size_t>(s.at(0)),
                  .mass = s.at(1),
                  .settled_for = s.at(2),
                  .rms_speed = s.at(3),
                  .bulk_density = s.at(4),
                  .surface_mean = s.at(5),
                  .surface_spread = s.at(6),
                  .coordination = s.at(7),
                  .carved = static_cast<std::size_t>(s.at(8))};
    saved.container_shift = s.at(9);
  }
  if (in.has("machine")) saved.machine = in.get<double>("machine");
  saved.coupling = in.get<double>("coupling");
  return saved;
}

void refuse_other(const SavedRun& saved, const Scenario& scenario, const std::filesystem::path& file) {
  const bool soil = scenario.soil.has_value() || !scenario.boundaries.empty(), machine = scenario.machine.has_value();
  if (saved.has_bed == soil && saved.machine.empty() == !machine) return;
  const auto parts = [](bool with_soil, bool with_machine) {
    return with_soil && with_machine ? "soil and machine" : with_soil ? "soil" : "a machine";
  };
  throw ScenarioError(file.string() + ": is the state of another scenario: it holds " +
                      parts(saved.has_bed, !saved.machine.empty()) + ", this scenario has " + parts(soil, machine) +
                      "; take a state that this scenario wrote");
}

std::vector<dem::SphereSpec> spheres_of(const SavedRun& saved) {
  std::vector<dem::SphereSpec> out;
  for (std::size_t i = 0; i < saved.bed.ids.size() / 2; ++i) {
    const double* s = saved.bed.spheres.data() + 11 * i;
    const double r = s[9];
    out.push_back({.position = {s[0], s[1], s[2]},
                   .velocity = {s[3], s[4], s[5]},
                   .angular_velocity = {},
                   .radius = r,
                   .density = s[10] / dem::sphere_volume(r),
                   .material = static_cast<int>(saved.bed.ids[2 * i + 1])});
  }
  return out;
}

void restore(const SavedRun& saved, World& world, coupling::Simulation& simulation) {
  if (world.bed) {
    world.bed->restore(saved.bed);
    world.soil = saved.soil;
    world.container_shift = saved.container_shift;
    world.bed->set_floor_drop(world.bed->options().floor_drop + saved.container_shift);
  }
  if (world.machine) world.machine->restore(saved.machine);
  simulation.restore(saved.coupling);
}

}  // namespace subsoil::app
