#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "apps/commands/beam_words.hpp"
#include "apps/commands/commands.hpp"
#include "apps/commands/stopwatch.hpp"
#include "apps/commands/trial.hpp"
#include "libsim/base/live_line.hpp"
#include "libsim/run/input_report.hpp"
#include "libsim/run/overlap_advice.hpp"
#include "libsim/run/placement_report.hpp"
#include "libsim/run/process.hpp"
#include "libsim/run/surface_report.hpp"
#include "libsim/scenario/gravity.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/machine.hpp"
#include "libsim/setup/soil.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {
namespace {

std::string duration_text(double seconds) {
  return seconds < 60 ? fmt::format("{:.2g} s", seconds) : clock_text(seconds);
}

std::string bytes_text(double bytes) {
  if (bytes > 1e9) return fmt::format("{:.2f} GB", bytes * 1e-9);
  return fmt::format("{:.1f} MB", bytes * 1e-6);
}

BuildOptions trial_options(const Loaded& loaded, const RunRequest& request) {
  BuildOptions options;
  options.threads = request.threads > 0 ? request.threads : static_cast<int>(loaded.scenario.time.threads);
  options.settle = false;
  return options;
}

double expected_spheres(const Loaded& loaded, World& world, const BuildOptions& options) {
  return world.bed ? SoilBuilder(world, loaded, options).expected_spheres() : 0;
}

std::string clump_words(const dem::ClumpShape& shape, const World& world) {
  std::size_t there = 0;
  for (const dem::Clump& c : world.bed->clumps()) there += &world.bed->clump_shapes()[c.shape] == &shape;
  const std::string count = there > 0 ? fmt::format("{} of", there) : "grains of";
  return fmt::format("{}: {} {} spheres, {:.4g} g, {:.4g} mm3 ({}), principal moments {:.4g} {:.4g} {:.4g} g mm2",
                     shape.name, count, shape.members.size(), shape.mass * 1e3, shape.volume * 1e9,
                     shape.error > 0 ? fmt::format("of the union, to {:.0e}", shape.error) : "exact",
                     shape.inertia.x * 1e9, shape.inertia.y * 1e9, shape.inertia.z * 1e9);
}

std::string inlet_words(const PouredSoil& one, double end) {
  double mass = 0;
  std::size_t spheres = 0, clumps = 0;
  for (const dem::InletGrain& grain : one.inlet.due_by(end)) {
    mass += grain.body.m;
    ++(grain.shape < 0 ? spheres : clumps);
  }
  const std::string grains = clumps == 0    ? fmt::format("{} spheres", spheres)
                             : spheres == 0 ? fmt::format("{} clumps", clumps)
                                            : fmt::format("{} spheres and {} clumps", spheres, clumps);
  return fmt::format("{}: {}, {:.4g} kg until {:.6g} s", one.name, grains, mass, end);
}

}  // namespace

Estimate estimate(const RunRequest& request) {
  const Clock::time_point begin = Clock::now();
  const Loaded loaded = load_scenario(request.scenario, request.sets);
  const BuildOptions options = trial_options(loaded, request);
  const double program = peak_memory();
  World world = build_world(loaded, options);
  const double spheres = expected_spheres(loaded, world, options);
  Estimate cost = try_out(loaded, world, spheres, seconds_since(begin)).cost;
  cost.memory_of_program = program;
  return cost;
}

int check_command(const RunRequest& request) {
  const Loaded loaded = load_scenario(request.scenario, request.sets);
  const Scenario& s = loaded.scenario;
  const BuildOptions options = trial_options(loaded, request);
  World world = build_world(loaded, options);
  const double spheres = expected_spheres(loaded, world, options), until_now = processor_time();
  const auto line = [](const char* name, const std::string& text) { fmt::print("{:<16}{}\n", name, text); };
  line("scenario", s.title.empty() ? request.scenario : s.title);
  if (world.bed) {
    const bool poured = s.soil && s.soil->bed && s.soil->bed->fill == Fill::random;
    line("spheres", poured && !s.soil->bed->count ? fmt::format("about {:.0f} (poured)", spheres)
                                                  : fmt::format("{:.0f}", spheres));
    for (const FibreGroup& group : world.fibres)
      line("fibres",
           fmt::format("{}: {} of {} spheres, {:.4g} mm long, {:.4g} kg", group.name, group.count, group.per_fibre(),
                       1e3 * group.shape.chain_length(), static_cast<double>(group.count) * group.shape.mass()));
    for (const PouredSoil& one : world.inlets) line("inlet", inlet_words(one, s.time.end));
    for (const dem::ClumpShape& shape : world.bed->clump_shapes()) line("clump", clump_words(shape, world));
    if (world.soil.spheres > 0 && !poured)
      line("bed as placed", fmt::format("{:.1f} kg", world.soil.mass) +
                                (acts_down(s.gravity) ? fmt::format(", bulk density {:.0f} kg/m3, surface at {:.4f} m",
                                                                    world.soil.bulk_density, world.soil.surface_mean)
                                                      : ""));
    line("soil step", fmt::format("{:.4g} s, {:.2f} of the stable step {:.4g} s", world.step.soil_step,
                                  world.step.soil_step / world.step.limit.step, world.step.limit.step));
    line("", "set by " + world.step.limit.cause);
    line("", accuracy_words(world.step));
  }
  if (world.machine) {
    const mbd::AssemblyReport& a = world.machine->assembly();
    const mbd::IntegratorKind kind = integrator_of(s);
    const bool own = kind == mbd::IntegratorKind::cvode || kind == mbd::IntegratorKind::ida;
    line("machine", fmt::format("{} bodies, {} equations, {} degrees of freedom, {} {:.4g} s",
                                world.machine->system().bodies() - 1, a.equations, a.freedom,
                                own ? "steps by their error, rows every" : "step", world.step.machine_step));
    line("", a.moved > 0 ? fmt::format("joints closed to {:.1e} m; assembly moves '{}' by {:.2e} m", a.residual,
                                       a.moved_body, a.moved)
                         : fmt::format("joints closed to {:.1e} m; nothing is moved", a.residual));
    for (auto r = a.redundant.begin(); r != a.redundant.end(); ++r)  // some depend in two ways
      if (std::find(a.redundant.begin(), r, *r) == r) line("", *r);
    for (const std::string& body : free_bodies(s, world))
      line("", fmt::format("`{}` is on no joint and has no driver: only forces hold it", body));
    for (const BeamSection& beam : s.machine->beams) line("beam", beam_words(beam));
  }
  const std::vector<SurfaceFacts> surfaces = surface_facts(world, s, s.time.end);
  for (std::size_t i = 0; i < surfaces.size(); ++i) line(i == 0 ? "surfaces" : "", surface_text(surfaces[i], world));
  for (const std::string& text : surface_warnings(surfaces, world)) line("warning", text);
  for (const std::string& text : input_warnings(loaded, world, request.scenario, request.sets)) line("warning", text);
  for (const std::string& text : placement_warnings(s, world)) line("warning", text);
  for (const std::string& text : travel_warnings(s, world)) line("warning", text);
  for (const FormerKey& key : loaded.former)
    line("former name", fmt::format("{}: `{}` is called `{}` now", loaded.where(key.path), key.former, key.present));
  if (!s.runs_in_time()) {
    line("analysis", analysis_names[static_cast<std::size_t>(s.analysis)]);
    return exit_ok;
  }
  if (const ExpectedOverlap deepest = expected_overlap(world, s); !deepest.tool.empty())
    line("overlap", overlap_text(deepest, s.limits.overlap));
  const Trial trial = try_out(loaded, world, spheres, until_now);
  line("steps", fmt::format("{} for {} s", trial.cost.steps, s.time.end));
  if (trial.settling > 0) {
    const bool compacts = s.soil && s.soil->bed && s.soil->bed->settle && s.soil->bed->settle->compacts();
    line("settling", fmt::format("about {:.2f} s simulated before the start{}", trial.settling,
                                 compacts ? ", and some times as long until it has come to `settle.to`" : ""));
  }
  if (world.bed)
    line("speed", fmt::format("{:.2f} M particle-steps/s, {} threads, {}", trial.particle_rate * 1e-6,
                              world.bed->threads(), world.bed->kernel_name()));
  const char* const of = world.inlets.empty() ? "" : ", without the grains of inlets";
  line("wall time", "about " + duration_text(trial.cost.wall_time) + of);
  line("memory", "about " + bytes_text(trial.cost.memory) + of);
  line("disk", fmt::format("about {} in {} frames{}", bytes_text(trial.cost.disk), trial.cost.frames, of));
  return exit_ok;
}

}  // namespace subsoil::sim
