#include "libsim/run/restart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "libsim/base/version.hpp"
#include "libsim/io/bed_state_file.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/setup/moving_soil.hpp"

namespace subsoil::sim {
namespace {

/// Of arrays and what they hold; a change in either takes the next number.
constexpr std::int64_t kStateFormat = 12;

void archive_layers(Archive& a, SoilReport& soil) {
  std::size_t count = soil.layers.size();
  a("count", count);
  for (std::size_t k = 0; k < count; ++k) {
    if (a.reads()) soil.layers.emplace_back();
    auto& [material, l] = soil.layers[k];
    a("material", material)("spheres", l.spheres)("mass", l.mass)("top", l.top)("spread", l.spread);
    a("thickness", l.thickness);
  }
}

void archive_fibres(Archive& a, SoilReport& soil) {
  a("from", soil.fibres_from)("displaced", soil.displaced)("at the start", soil.fibres);
}

/// What a run keeps of its soil beside the bed.
void archive_soil(Archive& a, SavedRun& saved) {
  SoilReport& s = saved.soil;
  a("step", saved.soil_step)("spheres", s.spheres)("mass", s.mass)("settled for", s.settled_for);
  if (!a.reads() || a.has("clumps")) a("clumps", s.clumps);
  a("rms speed", s.rms_speed)("bulk density", s.bulk_density)("surface mean", s.surface_mean);
  a("surface spread", s.surface_spread)("coordination", s.coordination)("carved", s.carved);
  a("container shift", saved.container_shift);
  a.group("layers", [&] { archive_layers(a, s); });
  if (!a.reads() || a.has("by depth")) a("by depth", s.by_depth);
  if (a.reads() ? a.has("fibres") : !s.fibres.empty()) a.group("fibres", [&] { archive_fibres(a, s); });
}

void archive_progress(Archive& a, RunProgress& p) {
  a("exact", p.exact)("series bytes", p.series_bytes)("energy start", p.energy_start);
}

void put_progress(StateWriter& out, const RunProgress& p) {
  Archive progress;
  archive_progress(progress, const_cast<RunProgress&>(p));  // to write changes nothing
  out.put("run/progress", progress);
  out.put("run/sums", p.sums);
  out.put("run/frames", p.frames.file_of);
  out.put("run/particles/id", p.particles.id);
  out.put("run/particles/radius", p.particles.radius);
  out.put("run/particles/density", p.particles.density);
  out.put("run/particles/material", p.particles.material);
  if (!p.particles.clump.empty()) out.put("run/particles/clump", p.particles.clump);
  if (!p.particles.fibre.empty()) out.put("run/particles/fibre", p.particles.fibre);
  if (!p.particles.volume.empty()) out.put("run/particles/solid volume", p.particles.volume);
  if (p.particles.repeats()) {
    out.put_vectors("run/particles/at rest", p.particles.at_rest);
    out.put("run/particles/period", p.particles.period);
  }
  out.put_texts("run/particles/material names", p.particles.material_names);
}

RunProgress progress_of(const StateReader& in) {
  RunProgress p;
  Archive progress = in.archive("run/progress");
  archive_progress(progress, p);
  progress.end();
  p.sums = in.archive("run/sums");
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
  if (in.has("run/particles/fibre")) p.particles.fibre = in.get<std::int32_t>("run/particles/fibre");
  if (in.has("run/particles/solid volume")) p.particles.volume = in.get<double>("run/particles/solid volume");
  return p;
}

/// Of a moving bed all but the spheres and contacts of its block.
void archive_block(Archive& a, dem::PeriodicBlock& block, dem::MovingBedPlan& plan) {
  a("low", block.low)("length", block.length)("across", block.across)("bonds across", block.bonds_across);
  a("stored", block.stored)("clumps", block.clumps)("shapes", block.shapes);
  a("rear", plan.rear)("step", plan.step)("steps", plan.steps)("direction", plan.direction);
}

void put_moving_bed(StateWriter& out, const dem::MovingBed& moving) {
  dem::PeriodicBlock block = moving.block();
  dem::MovingBedPlan plan = moving.plan();
  Archive shape, progress;
  archive_block(shape, block, plan);
  dem::MovingBed(moving).archive(progress);
  out.put("moving/block", shape);
  out.put("moving/progress", progress);
  put_spheres(out, "moving/", block.state);
}

dem::MovingBed moving_bed_of(const StateReader& in) {
  dem::PeriodicBlock block;
  dem::MovingBedPlan plan;
  Archive shape = in.archive("moving/block"), progress = in.archive("moving/progress");
  archive_block(shape, block, plan);
  shape.end();
  read_spheres(in, "moving/", block.state);
  dem::MovingBed out(std::move(block), plan);
  out.archive(progress);
  progress.end();
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
  for (const PouredSoil& one : world.inlets) saved.inlets.push_back(one.inlet.state());
  if (world.machine) saved.machine = world.machine->snapshot();
  saved.exchange = simulation.save();
  saved.version = version();
  return saved;
}

namespace {

template <class Part>
Archive archived(Part part) {
  Archive out;
  part.archive(out);
  return out;
}

}  // namespace

void write_run(const std::filesystem::path& path, const SavedRun& saved) {
  StateWriter out(path);
  out.put_format(kStateFormat);
  out.put_text("scenario", saved.scenario);
  if (!saved.begun_by.empty()) out.put_text("begun by", saved.begun_by);
  out.put("time", saved.time);
  if (saved.has_bed) {
    put_bed_state(out, saved.bed);
    Archive soil;
    archive_soil(soil, const_cast<SavedRun&>(saved));  // to write changes nothing
    out.put("soil", soil);
    out.put_text("instruction set", saved.kernel);
  }
  if (saved.moving) put_moving_bed(out, *saved.moving);
  if (!saved.inlets.empty()) {
    Archive inlets;
    inlets("inlets", const_cast<SavedRun&>(saved).inlets);
    out.put("inlets", inlets);
  }
  if (saved.machine) out.put("machine", archived(*saved.machine));
  out.put("coupling", archived(saved.exchange));
  out.put_text("version", saved.version);
  put_progress(out, saved.progress.value());
  out.commit();
}

void save_run(const std::filesystem::path& path, const Scenario& scenario, const std::string& begun_by,
              const World& world, const coupling::Simulation& simulation, const RunProgress& progress) {
  SavedRun saved = take_state(world, simulation);
  saved.scenario = write_scenario(scenario);
  if (begun_by != saved.scenario) saved.begun_by = begun_by;
  saved.progress = progress;
  write_run(path, saved);
}

namespace {

bool is_finite(double x) { return std::isfinite(x) && std::abs(x) < 1e30; }

bool is_finite(const Archive& a) {
  const Archive::Columns columns = a.columns();
  return std::all_of(columns.begin(), columns.end(), [](const auto& column) {
    return std::all_of(column.second.begin(), column.second.end(), [](double x) { return is_finite(x); });
  });
}

[[noreturn]] void refuse_numbers() {
  throw std::runtime_error("holds numbers that are not finite or beyond 1e30; the file is damaged");
}

/// Of records that are plain numbers but for whole ones, which are none that is not finite.
bool is_finite(const dem::PairState& s) {
  bool finite = true;
  const auto look = [&](auto number, int) { finite = finite && is_finite(static_cast<double>(number)); };
  dem::each_field(dem::MemoryShape::whole(), s, look, look);
  return finite;
}
bool is_finite(const dem::BondMemory<double>& b) {
  bool finite = true;
  const auto look = [&](double number, int) { finite = finite && is_finite(number); };
  dem::BondMemory<double>::each_state(b, look);
  dem::BondMemory<double>::each_diagnostic(b, look);
  return finite;
}

bool is_finite(const dem::Bed::State& bed) {
  const auto all = [](const auto& records) {
    return std::all_of(records.begin(), records.end(), [](const auto& r) { return is_finite(r.state); });
  };
  const auto point = [](const Vec3& v) { return is_finite(v.x) && is_finite(v.y) && is_finite(v.z); };
  return std::all_of(bed.spheres.begin(), bed.spheres.end(),
                     [&](const dem::Sphere& s) { return point(s.x) && point(s.v) && point(s.w) && is_finite(s.r); }) &&
         all(bed.pairs) && all(bed.bonds) && all(bed.surfaces) && is_finite(bed.parts);
}

/// Everything that spheres are made of, before anything is built from it.
void check_numbers(const SavedRun& saved) {
  if (!std::isfinite(saved.time) || std::abs(saved.time) > 1e12 || !is_finite(saved.bed) ||
      !(saved.soil_step >= 0 && saved.soil_step < 1e6) ||
      std::any_of(saved.inlets.begin(), saved.inlets.end(), [](const dem::InletState& i) { return !(i.interval > 0); }))
    refuse_numbers();
  for (const dem::Sphere& s : saved.bed.spheres)
    if (!(s.r > 0) || !(s.m > 0) || s.id >= 1000000000 || s.kind > dem::SphereKind::member)
      throw std::runtime_error(
          fmt::format("sphere {} has radius {:.3g} m, mass {:.3g} kg, kind {}; the file is damaged", s.id, s.r, s.m,
                      static_cast<int>(s.kind)));
}

template <class Part>
void read_part(const StateReader& in, const std::string& name, Part& part) {
  Archive a = in.archive(name);
  if (!is_finite(a)) refuse_numbers();
  part.archive(a);
  a.end();
}

SavedRun run_in(const StateReader& in);

}  // namespace

SavedRun read_run(const std::filesystem::path& file) {
  bool opened = false;
  try {
    const StateReader in(file);
    opened = true;
    return run_in(in);
  } catch (const std::bad_alloc&) {
    throw;  // the machine's fault, not the file's
  } catch (const std::exception& error) {
    throw StateFault(file, opened ? file.string() + ": " + error.what() : error.what());
  }
}

namespace {

SavedRun run_in(const StateReader& in) {
  in.require_format(kStateFormat, {"bed/", "moving/", "inlets/", "soil/", "instruction set", "version", "machine/",
                                   "coupling/", "scenario", "begun by", "time", "run/"});
  SavedRun saved;
  saved.version = in.text("version");
  if (in.has("run/progress")) {
    saved.progress = progress_of(in);
    saved.exact = saved.progress->exact;
  }
  if (in.has("scenario")) saved.scenario = in.text("scenario"), saved.time = in.value<double>("time");
  if (in.has("begun by")) saved.begun_by = in.text("begun by");
  saved.has_bed = in.has("bed/parts");
  if (saved.has_bed) {
    saved.bed = bed_state_of(in);
    Archive soil = in.archive("soil");
    archive_soil(soil, saved);
    soil.end();
    saved.kernel = in.text("instruction set");
  }
  if (in.has("moving/block")) saved.moving = std::make_shared<dem::MovingBed>(moving_bed_of(in));
  if (in.has("inlets")) {
    Archive inlets = in.archive("inlets");
    if (!is_finite(inlets)) refuse_numbers();
    inlets("inlets", saved.inlets);
    inlets.end();
  }
  if (in.has("machine")) read_part(in, "machine", saved.machine.emplace());
  read_part(in, "coupling", saved.exchange);
  check_numbers(saved);
  return saved;
}

}  // namespace

void refuse_other(const SavedRun& saved, const Scenario& scenario, const std::filesystem::path& file) {
  const bool soil = scenario.soil.has_value() || !scenario.boundaries.empty(), machine = scenario.machine.has_value();
  if (saved.has_bed == soil && saved.machine.has_value() == machine) return;
  const auto parts = [](bool with_soil, bool with_machine) {
    return with_soil && with_machine ? "soil and machine" : with_soil ? "soil" : "a machine";
  };
  throw ScenarioError(file.string() + ": is the state of another scenario: it holds " +
                      parts(saved.has_bed, saved.machine.has_value()) + ", this scenario has " + parts(soil, machine) +
                      "; take a state that this scenario wrote");
}

std::vector<dem::SphereSpec> spheres_of(const SavedRun& saved) {
  std::vector<dem::SphereSpec> out;
  for (const dem::Sphere& s : saved.bed.spheres)
    out.push_back({.position = s.x,
                   .velocity = s.v,
                   .angular_velocity = {},
                   .radius = s.r,
                   .density = dem::density(s),
                   .material = s.material,
                   .kind = s.kind});
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
    number_fibres(world);
    world.bed->set_floor_drop(world.bed->options().floor_drop + saved.container_shift - world.container_shift);
    world.container_shift = saved.container_shift;
    if (saved.inlets.size() != world.inlets.size())
      throw ScenarioError(
          "soil.inlets: the state was written with other inlets; take a state that this scenario wrote");
    for (std::size_t k = 0; k < world.inlets.size(); ++k) world.inlets[k].inlet.restore(saved.inlets[k]);
  }
  if (world.machine) world.machine->restore(saved.machine.value());
  simulation.restore(saved.exchange);
}

}  // namespace subsoil::sim
