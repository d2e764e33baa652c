#include "libsim/run/restart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/base/version.hpp"
#include "libsim/io/bed_state_file.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/setup/moving_soil.hpp"

namespace subsoil::sim {
namespace {

/// 2: memory of contacts in the order of libdem/contacts/contact_memory.hpp, bonds with what they released. (Before: no
/// number.) 3: neighbour lists, what the run has added up, steps; checksums.
constexpr std::int64_t kStateFormat = 4;

void put_progress(StateWriter& out, const RunProgress& p) {
  out.put("run/exact", static_cast<std::uint8_t>(p.exact ? 1 : 0));
  out.put("run/sums", p.sums.numbers());
  out.put_texts("run/texts", p.sums.texts());
  out.put("run/series bytes", p.series_bytes);
  out.put("run/energy start", p.energy_start);
  out.put("run/frames", p.frames.file_of);
  out.put("run/particles/id", p.particles.id);
  out.put("run/particles/radius", p.particles.radius);
  out.put("run/particles/density", p.particles.density);
  out.put("run/particles/material", p.particles.material);
  if (!p.particles.clump.empty()) out.put("run/particles/clump", p.particles.clump);
  if (p.particles.repeats()) {
    out.put_vectors("run/particles/at rest", p.particles.at_rest);
    out.put("run/particles/period", p.particles.period);
  }
  out.put_texts("run/particles/material names", p.particles.material_names);
}

RunProgress progress_of(const StateReader& in) {
  RunProgress p;
  p.sums = Archive(in.get<double>("run/sums"), in.texts("run/texts"));
  p.series_bytes = in.value<std::uint64_t>("run/series bytes");
  if (in.has("run/energy start")) p.energy_start = in.get<double>("run/energy start");
  p.frames.file_of = in.get<std::int64_t>("run/frames");
  p.particles = {.id = in.get<std::int64_t>("run/particles/id"),
                 .radius = in.get<double>("run/particles/radius"),
                 .density = in.get<double>("run/particles/density"),
                 .material = in.get<std::int32_t>("run/particles/material"),
                 .material_names = in.texts("run/particles/material names")};
  if (in.has("run/particles/at rest")) {
    p.particles.at_rest = in.get_vectors("run/particles/at rest");
    p.particles.period = in.value<double>("run/particles/period");
  }
  if (in.has("run/particles/clump")) p.particles.clump = in.get<std::int32_t>("run/particles/clump");
  return p;
}

void put_moving_bed(StateWriter& out, const dem::MovingBed& moving) {
  const dem::PeriodicBlock& block = moving.block();
  const dem::MovingBedPlan& plan = moving.plan();
  out.put("moving/plan", std::vector<double>{block.low, block.length, plan.rear, plan.step,
                                             static_cast<double>(plan.steps), static_cast<double>(plan.direction)});
  std::vector<std::int64_t> stored_in;
  std::vector<double> stored;
  for (const dem::StoredInContact& c : block.stored)
    stored_in.insert(stored_in.end(), {c.i, c.j, c.across}), stored.push_back(c.energy);
  out.put("moving/stored in", stored_in);
  out.put("moving/stored", stored);
  out.put("moving/numbers", moving.save());
  out.put("moving/across", block.across);
  put_spheres(out, "moving/", block.state);
}

dem::MovingBed moving_bed_of(const StateReader& in) {
  const std::vector<double> n = in.get<double>("moving/plan");
  if (n.size() != 6) throw std::invalid_argument("what it has of the moving bed is damaged");
  dem::PeriodicBlock block{.low = n[0], .length = n[1], .state = {}, .across = {}, .stored = {}};
  const auto stored_in = in.get<std::int64_t>("moving/stored in");
  const auto stored = in.get<double>("moving/stored");
  if (stored_in.size() != 3 * stored.size()) throw std::invalid_argument("what it has of the moving bed is damaged");
  for (std::size_t k = 0; k < stored.size(); ++k)
    block.stored.push_back({stored_in[3 * k], stored_in[3 * k + 1], stored_in[3 * k + 2], stored[k]});
  block.across = in.get<std::int64_t>("moving/across");
  read_spheres(in, "moving/", block.state);
  dem::MovingBed out(
      std::move(block),
      {.rear = n[2], .step = n[3], .steps = static_cast<int>(n[4]), .direction = static_cast<int>(n[5])});
  out.restore(in.get<double>("moving/numbers"));
  return out;
}

}  // namespace

SavedRun take_state(const World& world, const coupling::Simulation& simulation, dem::Bed::Checkpoint* checkpoint) {
  SavedRun saved;
  saved.time = simulation.time();
  saved.has_bed = world.bed != nullptr;
  if (world.bed) {
    if (checkpoint != nullptr)
      world.bed->save(*checkpoint);
    else
      saved.bed = world.bed->save();
    saved.soil_step = world.step.soil_step;
    saved.kernel = world.bed->kernel_name();
    saved.soil = world.soil;
    saved.container_shift = world.container_shift;
  }
  if (world.moving) saved.moving = std::make_shared<dem::MovingBed>(world.moving->window);
  if (world.machine) saved.machine = world.machine->snapshot();
  saved.coupling = simulation.save();
  saved.version = version();
  return saved;
}

void write_run(const std::filesystem::path& path, const SavedRun& saved) {
  StateWriter out(path);
  out.put_format(kStateFormat);
  out.put_text("scenario", saved.scenario);
  out.put("time", saved.time);
  if (saved.has_bed) {
    put_bed_state(out, saved.bed);
    out.put("soil step", saved.soil_step);
    out.put_text("instruction set", saved.kernel);
    const SoilReport& s = saved.soil;
    out.put("soil", std::vector<double>{static_cast<double>(s.spheres), s.mass, s.settled_for, s.rms_speed,
                                        s.bulk_density, s.surface_mean, s.surface_spread, s.coordination,
                                        static_cast<double>(s.carved), saved.container_shift});
    std::vector<std::string> names;
    std::vector<double> layers;
    for (const auto& [material, l] : s.layers) {
      names.push_back(material);
      layers.insert(layers.end(), {static_cast<double>(l.spheres), l.mass, l.top, l.spread, l.thickness});
    }
    out.put_texts("layers/materials", names);
    out.put("layers/numbers", layers);
  }
  if (saved.moving) put_moving_bed(out, *saved.moving);
  if (!saved.machine.empty()) out.put("machine", saved.machine);
  out.put("coupling", saved.coupling);
  out.put_text("version", saved.version);
  put_progress(out, saved.progress.value());
  out.commit();
}

void save_run(const std::filesystem::path& path, const Scenario& scenario, const World& world,
              const coupling::Simulation& simulation, const RunProgress& progress) {
  SavedRun saved = take_state(world, simulation);
  saved.scenario = write_scenario(scenario);
  saved.progress = progress;
  write_run(path, saved);
}

namespace {

[[noreturn]] void refuse_arrays(const std::filesystem::path& file) {
  throw std::runtime_error(file.string() + ": its arrays do not belong together; the file is damaged");
}

/// Everything that spheres are made of, before anything is built from it.
void check_numbers(const SavedRun& saved, const std::filesystem::path& file) {
  const auto finite = [](const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x) && std::abs(x) < 1e30; });
  };
  if (!std::isfinite(saved.time) || std::abs(saved.time) > 1e12 || !finite(saved.coupling) || !finite(saved.machine) ||
      !finite(saved.bed.spheres) || !finite(saved.bed.pairs) || !finite(saved.bed.bonds) ||
      !finite(saved.bed.surfaces) || !finite(saved.bed.scalars) || !finite(saved.bed.loads) ||
      !finite(saved.bed.clumps) || !(saved.soil_step >= 0 && saved.soil_step < 1e6))
    throw std::runtime_error(file.string() + ": holds numbers that are not finite or beyond 1e30; the file is damaged");
  if (!saved.has_bed) return;
  const std::size_t count = saved.bed.ids.size() / 2;
  if (saved.bed.spheres.size() != 11 * count || saved.bed.ids.size() != 2 * count) refuse_arrays(file);
  if (!saved.bed.kinds.empty() && saved.bed.kinds.size() != count) refuse_arrays(file);
  if (saved.bed.kinds.empty() && !saved.bed.fixed.empty())
    throw std::runtime_error(file.string() +
                             ": has fixed spheres and does not name them: it is of an older version; start "
                             "the run again, or continue with the version that wrote it");
  for (std::size_t k = 0; k < count; ++k) {
    const double radius = saved.bed.spheres[11 * k + 9], mass = saved.bed.spheres[11 * k + 10];
    const std::int64_t id = saved.bed.ids[2 * k], material = saved.bed.ids[2 * k + 1];
    if (!(radius > 0) || !(mass > 0) || id < 0 || id >= 1000000000 || material < 0 || material > 65535)
      throw std::runtime_error(
          fmt::format("{}: sphere {} has radius {:.3g} m, mass {:.3g} kg, number {}, material {}; the file is damaged",
                      file.string(), k, radius, mass, id, material));
  }
}

}  // namespace

SavedRun read_run(const std::filesystem::path& file) {
  const StateReader in(file);
  in.require_format(kStateFormat, {"bed/spheres",
                                   "bed/ids",
                                   "bed/pair ids",
                                   "bed/pairs",
                                   "bed/surface ids",
                                   "bed/surfaces",
                                   "bed/scalars",
                                   "bed/bonding",
                                   "bed/bond ids",
                                   "bed/bonds",
                                   "bed/broken ids",
                                   "bed/broken",
                                   "bed/calm",
                                   "bed/frozen",
                                   "bed/fixed",
                                   "bed/clumps",
                                   "bed/loads",
                                   "bed/kinds",
                                   "moving/",
                                   "soil",
                                   "soil step",
                                   "layers/",
                                   "instruction set",
                                   "version",
                                   "machine",
                                   "coupling",
                                   "scenario",
                                   "time",
                                   "run/"});
  SavedRun saved;
  saved.version = in.text("version");
  if (in.has("run/sums")) {
    saved.progress = progress_of(in);
    saved.exact = saved.progress->exact = in.value<std::uint8_t>("run/exact") != 0;
  }
  if (in.has("scenario")) saved.scenario = in.text("scenario"), saved.time = in.value<double>("time");
  saved.has_bed = in.has("bed/spheres");
  if (saved.has_bed) {
    saved.bed = bed_state_of(in);
    saved.soil_step = in.value<double>("soil step");
    saved.kernel = in.text("instruction set");
    const std::vector<double> s = in.get<double>("soil"), layers = in.get<double>("layers/numbers");
    if (s.size() != 10) refuse_arrays(file);
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
    const std::vector<std::string> names = in.texts("layers/materials");
    if (layers.size() != 5 * names.size()) refuse_arrays(file);
    for (std::size_t k = 0; k < names.size(); ++k)
      saved.soil.layers.push_back({names[k],
                                   {.spheres = static_cast<std::size_t>(layers[5 * k]),
                                    .mass = layers[5 * k + 1],
                                    .top = layers[5 * k + 2],
                                    .spread = layers[5 * k + 3],
                                    .thickness = layers[5 * k + 4]}});
  }
  if (in.has("moving/plan")) saved.moving = std::make_shared<dem::MovingBed>(moving_bed_of(in));
  if (in.has("machine")) saved.machine = in.get<double>("machine");
  saved.coupling = in.get<double>("coupling");
  check_numbers(saved, file);
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
    out.push_back(
        {.position = {s[0], s[1], s[2]},
         .velocity = {s[3], s[4], s[5]},
         .angular_velocity = {},
         .radius = r,
         .density = s[10] / dem::sphere_volume(r),
         .material = static_cast<int>(saved.bed.ids[2 * i + 1]),
         .kind = saved.bed.kinds.empty() ? dem::SphereKind::free : static_cast<dem::SphereKind>(saved.bed.kinds[i])});
  }
  return out;
}

void restore(const SavedRun& saved, World& world, coupling::Simulation& simulation,
             const dem::Bed::Checkpoint* checkpoint) {
  if (world.bed) {
    if (checkpoint != nullptr)
      world.bed->restore(*checkpoint);
    else
      world.bed->restore(saved.bed);
    world.soil = saved.soil;
    world.soil.clumps = world.bed->clumps().size();
    world.bed->set_floor_drop(world.bed->options().floor_drop + saved.container_shift - world.container_shift);
    world.container_shift = saved.container_shift;
  }
  if (world.machine) world.machine->restore(saved.machine);
  simulation.restore(saved.coupling);
}

}  // namespace subsoil::sim
