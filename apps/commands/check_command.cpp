#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "apps/build/machine.hpp"
#include "apps/build/soil.hpp"
#include "apps/build/world.hpp"
#include "apps/commands/commands.hpp"
#include "apps/run/columns.hpp"
#include "apps/run/frames.hpp"
#include "apps/run/input_report.hpp"
#include "apps/run/live_line.hpp"
#include "apps/run/overlap_advice.hpp"
#include "apps/run/process.hpp"
#include "apps/run/surface_report.hpp"
#include "apps/scenario/load.hpp"

namespace subsoil::app {
namespace {

/// A folder that is gone afterwards, also when something is thrown.
struct ScratchFolder {
  ScratchFolder()
      : path(std::filesystem::temp_directory_path() / fmt::format("subsoil-check-{}", static_cast<long>(getpid()))) {
    std::filesystem::create_directories(path);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::filesystem::path path;
};

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

/// Bytes that one frame takes in the file: written for real beside nobody's files, then deleted. Twice, so that what
/// the file holds once (radii, ids) drops out of the difference.
struct FrameSize {
  double once = 0, each = 0;
};
FrameSize frame_size(const Scenario& s, const dem::Snapshot& shot) {
  if (shot.id.empty()) return {4e5, 1e4};
  const ScratchFolder scratch;
  const std::filesystem::path& dir = scratch.path;
  double size[2] = {};
  for (int count = 1; count <= 2; ++count) {
    ParticleTable table;
    table.material_names = {"soil"};
    for (std::size_t i = 0; i < shot.id.size(); ++i) {
      table.id.push_back(shot.id[i]);
      table.radius.push_back(shot.radius[i]);
      table.density.push_back(0);
      table.material.push_back(0);
    }
    {
      RunWriter writer(dir, std::move(table), {}, frame_options(s));
      for (int k = 0; k < count; ++k) {
        Frame frame;
        frame.time = k;
        frame.position = shot.position, frame.velocity = shot.velocity, frame.spin = shot.angular_velocity;
        frame.force = shot.force, frame.torque = shot.torque, frame.contacts = shot.contacts;
        writer.write(frame);
      }
      writer.finish();
    }
    for (const auto& file : std::filesystem::directory_iterator(dir / "frames"))
      size[count - 1] += static_cast<double>(file.file_size());
  }
  return {2 * size[0] - size[1], size[1] - size[0]};
}

/// Longest settling that is likely: fall of the loose column, the ramp of the staged laws, and the relaxation of the
/// bed, taken as twenty times the time a sphere needs to fall by its radius.
double settling_time(const Scenario& s, const World& world) {
  if (!s.soil || !s.soil->bed) return 0;
  const BedSection& bed = *s.soil->bed;
  if (!bed.settle && bed.fill != Fill::random) return 0;
  const Settle settle = bed.settle.value_or(Settle{});
  double time = settle.duration.value_or(0);
  const double g = dem::norm(s.gravity);
  if (time == 0 && g > 0 && !world.bed->spheres().empty()) time = 20 * std::sqrt(2 * world.bed->spheres()[0].r / g);
  if (bed.fill == Fill::random && g > 0 && s.soil->container) time += std::sqrt(8 * s.soil->container->size.y / g);
  if (settle.staged(bed.fill)) time += settle.ramp;
  return std::min(time, settle.at_most);
}

std::string duration_text(double seconds) {
  return seconds < 60 ? fmt::format("{:.2g} s", seconds) : clock_text(seconds);
}

std::string bytes_text(double bytes) {
  if (bytes > 1e9) return fmt::format("{:.2f} GB", bytes * 1e-9);
  return fmt::format("{:.1f} MB", bytes * 1e-6);
}

struct Trial {
  Estimate cost;
  double spheres = 0;  ///< expected of the run; the trial's bed is a stand-in where it is poured
  double settling = 0;
  double particle_rate = 0;
};

/// Steps the real thing for a second or two.
Trial try_out(const Loaded& loaded, World& world, double spheres) {
  const Scenario& s = loaded.scenario;
  coupling::Simulation simulation(world.bed.get(), world.machine.get(), world.body_surfaces, world.motions,
                                  {.soil_step = world.step.soil_step,
                                   .soil_steps = static_cast<int>(s.time.machine.soil_steps),
                                   .machine_step = world.step.machine_step});
  Columns columns(loaded, world, simulation);
  std::vector<double> row(columns.list().size(), 0.0);
  const auto step = [&](const dem::Bed::Request& request) {
    if (columns.needs_every_step()) columns.take_instant(row);
    simulation.step(request);
    if (columns.has_means()) columns.take_step(row, false);
  };
  Trial trial;
  trial.spheres = spheres;
  for (int k = 0; k < 3; ++k) step({});
  const Clock::time_point start = Clock::now();
  long count = 0;
  // Batches, of which the middle one counts: a spell of other work on the machine is not taken for the run's own.
  std::vector<double> batches;
  for (; count < 5 || (seconds_since(start) < 2.0 && count < 2000);) {
    const Clock::time_point begin = Clock::now();
    const int size = count < 5 ? 5 : 20;
    for (int k = 0; k < size; ++k) step({});
    batches.push_back(seconds_since(begin) / size);
    count += size;
  }
  std::nth_element(batches.begin(), batches.begin() + static_cast<long>(batches.size() / 2), batches.end());
  const double there = world.bed ? static_cast<double>(world.bed->spheres().size()) : 0;
  const double more = there > 0 ? trial.spheres / there : 1;
  trial.cost.seconds_per_step = more * batches[batches.size() / 2];
  dem::Snapshot shot;
  if (world.bed) {
    // Lists are built while the memory of the contacts before stands beside them: that is when a run needs most.
    world.bed->surfaces_changed();
    step({.energy = true, .snapshot = &shot});
  }

  const double dt = simulation.step_length();
  trial.cost.steps = std::lround(s.time.end / dt);
  trial.settling = settling_time(s, world);
  const double every = frame_interval(s);
  trial.cost.frames = (every > 0 ? std::lround(s.time.end / every) + 1 : 1) + static_cast<long>(s.output.at.size());
  const Clock::time_point writing = Clock::now();
  FrameSize frame = frame_size(s, shot);
  frame.once *= more, frame.each *= more;
  const double seconds_per_frame = more * seconds_since(writing) / 3;
  // A bed settles with the stable step, however fine the run's own is for its impacts.
  const double settling_step = s.time.soil_step ? dt : s.time.safety * world.step.limit.step;
  trial.cost.wall_time =
      trial.cost.seconds_per_step * (static_cast<double>(trial.cost.steps) + trial.settling / settling_step) +
      seconds_per_frame * static_cast<double>(trial.cost.frames);
  const double interval = s.output.row_interval();
  const double rows = (interval > 0 ? s.time.end / interval : 0) + static_cast<double>(s.output.series_at.size()) + 1;
  const double series = rows * (world.bed ? 11.0 : 20.0) * static_cast<double>(row.size());
  double state = 0;
  if (world.bed && (s.output.state == State::full || s.output.state_every)) {
    const double states = 1 + (s.output.state_every ? s.time.end / *s.output.state_every : 0);
    state = states * more *
            (104.0 * static_cast<double>(shot.id.size()) + 128.0 * static_cast<double>(world.bed->touching_pairs()));
  }
  trial.cost.disk = frame.once + frame.each * static_cast<double>(trial.cost.frames) + series + state;
  trial.cost.memory = peak_memory();
  if (world.bed) {
    constexpr double bytes = 520;  // of a sphere in a bed that is stepped (docs/performance.md)
    trial.cost.memory += std::max(0.0, spheres - there) * bytes;
    trial.particle_rate = spheres / trial.cost.seconds_per_step;
  }
  return trial;
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

}  // namespace

Estimate estimate(const RunRequest& request) {
  const Loaded loaded = load_scenario(request.scenario, request.sets);
  const BuildOptions options = trial_options(loaded, request);
  World world = build_world(loaded, options);
  return try_out(loaded, world, expected_spheres(loaded, world, options)).cost;
}

int check_command(const RunRequest& request) {
  const Loaded loaded = load_scenario(request.scenario, request.sets);
  const Scenario& s = loaded.scenario;
  const BuildOptions options = trial_options(loaded, request);
  World world = build_world(loaded, options);
  const double spheres = expected_spheres(loaded, world, options);
  const auto line = [](const char* name, const std::string& text) { fmt::print("{:<16}{}\n", name, text); };
  line("scenario", s.title.empty() ? request.scenario : s.title);
  if (world.bed) {
    const bool poured = s.soil && s.soil->bed && s.soil->bed->fill == Fill::random;
    line("spheres", poured && !s.soil->bed->count ? fmt::format("about {:.0f} (poured)", spheres)
                                                  : fmt::format("{:.0f}", spheres));
    if (world.soil.spheres > 0 && !poured)
      line("bed as placed", fmt::format("{:.1f} kg, bulk density {:.0f} kg/m3, surface at {:.4f} m", world.soil.mass,
                                        world.soil.bulk_density, world.soil.surface_mean));
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
    for (const std::string& r : a.redundant) line("", r);
  }
  const std::vector<SurfaceFacts> surfaces = surface_facts(world, s.time.end);
  for (std::size_t i = 0; i < surfaces.size(); ++i) line(i == 0 ? "surfaces" : "", surface_text(surfaces[i], world));
  for (const std::string& text : surface_warnings(surfaces, world)) line("warning", text);
  for (const std::string& text : input_warnings(loaded, world, request.scenario, request.sets)) line("warning", text);
  if (!s.runs_in_time()) {
    line("analysis", analysis_names[static_cast<std::size_t>(s.analysis)]);
    return exit_ok;
  }
  if (const ExpectedOverlap deepest = expected_overlap(world, s); !deepest.tool.empty())
    line("overlap", overlap_text(deepest, s.limits.overlap));
  const Trial trial = try_out(loaded, world, spheres);
  line("steps", fmt::format("{} for {} s", trial.cost.steps, s.time.end));
  if (trial.settling > 0) line("settling", fmt::format("about {:.2f} s simulated before the start", trial.settling));
  if (world.bed)
    line("speed", fmt::format("{:.2f} M particle-steps/s, {} threads, {}", trial.particle_rate * 1e-6,
                              world.bed->threads(), world.bed->kernel_name()));
  line("wall time", "about " + duration_text(trial.cost.wall_time));
  line("memory", "about " + bytes_text(trial.cost.memory));
  line("disk", fmt::format("about {} in {} frames", bytes_text(trial.cost.disk), trial.cost.frames));
  return exit_ok;
}

}  // namespace subsoil::app
