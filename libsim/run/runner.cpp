#include "libsim/run/runner.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <optional>
#include <utility>

#include "libdem/bed_engine.hpp"
#include "libsim/base/json.hpp"
#include "libsim/base/live_line.hpp"
#include "libsim/base/signals.hpp"
#include "libsim/base/version.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/frame_parts.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/run/analysis.hpp"
#include "libsim/run/checkpoints.hpp"
#include "libsim/run/columns.hpp"
#include "libsim/run/continuation.hpp"
#include "libsim/run/crossings.hpp"
#include "libsim/run/engine_program.hpp"
#include "libsim/run/frames.hpp"
#include "libsim/run/output_folder.hpp"
#include "libsim/run/restart.hpp"
#include "libsim/run/resume.hpp"
#include "libsim/run/run_loop.hpp"
#include "libsim/run/settling_checkpoint.hpp"
#include "libsim/scenario/gravity.hpp"
#include "libsim/setup/active_rule.hpp"
#include "libsim/setup/moving_soil.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {
namespace {

/// Between two steps there is nothing to see but the interpolation. (Where nothing is said, there are as many as there
/// can be.)
void say_dense_frames(const Loaded& loaded, const World& world) {
  if (!loaded.scenario.output.every || !world.bed) return;
  const double every = frame_interval(loaded.scenario);
  if (every < world.step.soil_step)
    spdlog::warn(
        "warning: output.every = {:.3g} s: is shorter than the step of {:.3g} s; frames between steps are interpolated "
        "(a movie needs some 10 ms)",
        every, world.step.soil_step);
}

void report_soil(const World& world) {
  if (!world.bed || world.soil.spheres == 0) return;
  const std::string surface =
      acts_down(world.bed->options().gravity)
          ? fmt::format("bulk density {:.0f} kg/m3, surface at {:.4f} m (spread {:.1f} mm), ", world.soil.bulk_density,
                        world.soil.surface_mean, world.soil.surface_spread * 1e3)
          : "";
  spdlog::info("soil: {} spheres, {:.1f} kg, {}{:.2f} contacts per sphere", world.soil.spheres, world.soil.mass,
               surface, world.soil.coordination);
  for (const FibreGroup& group : world.fibres)
    spdlog::info("fibres {}: {} of {} spheres, {:.3g} kg", group.name, group.count, group.per_fibre(),
                 static_cast<double>(group.count) * group.shape.mass());
  if (world.soil.displaced > 0) spdlog::info("{} spheres of the bed left out for fibres", world.soil.displaced);
  for (const auto& [material, layer] : world.soil.layers)
    spdlog::info("layer of {}: {} spheres, {:.1f} mm thick, top at {:.4f} m (spread {:.1f} mm)", material,
                 layer.spheres, layer.thickness * 1e3, layer.top, layer.spread * 1e3);
  for (const DepthRow& row : world.soil.by_depth)
    spdlog::info(
        "at {:.0f} mm depth: {:.0f} kg/m3, {:.2f} contacts per sphere, {:.3g} kPa, horizontal over vertical stress "
        "{:.2f}",
        row.depth * 1e3, row.density, row.coordination, row.vertical_stress * 1e-3, row.stress_ratio);
  if (world.soil.settled_for > 0)
    spdlog::info("settled for {:.3f} s to an rms speed of {:.2g} m/s", world.soil.settled_for, world.soil.rms_speed);
  if (world.soil.carved > 0) spdlog::info("{} spheres removed for the machine", world.soil.carved);
}

/// What the scenario says otherwise than the one that wrote the state: listed, and refused where it must be.
std::vector<Difference> look_at_changes(const SavedRun& saved, const Loaded& loaded, const RunRequest& request) {
  if (saved.scenario.empty()) {
    spdlog::warn("warning: {} does not name the scenario that wrote it: nothing was compared", request.from.string());
    return {};
  }
  const std::vector<Difference> found = differences(saved.scenario, write_scenario(loaded.scenario));
  refuse_changes(found, request.changes, request.from.string());
  if (loaded.scenario.time.end <= saved.time)
    throw ScenarioError(fmt::format("{} = {:.6g} s: the state is of {:.6g} s; give a later end",
                                    loaded.where("time.end"), loaded.scenario.time.end, saved.time));
  for (const Difference& d : found)
    if (d.kind != Difference::Kind::harmless) spdlog::info("changed: {} from {} to {}", d.key, d.before, d.now);
  return found;
}

/// Throws ScenarioError for a file that is no state, or a damaged one.
SavedRun read_state(const std::filesystem::path& file) {
  try {
    return read_run(file);
  } catch (const StateFault& error) {
    throw ScenarioError(error.what());
  }
}

/// What keeps the end from being the same bits, said and no reason to stop: the program that wrote a file, and ours.
void look_at_program(const std::string& its_version, const std::string& its_kernel, const World& world,
                     const std::filesystem::path& from) {
  if (its_version != version())
    spdlog::warn("warning: {} was written by version {}, this is {}: the end may differ in its last digits",
                 from.string(), its_version, version());
  if (world.bed && its_kernel != world.bed->kernel_name())
    spdlog::warn(
        "warning: {} was written with the instruction set {}, this run uses {}: the end may differ in its last "
        "digits; --simd {} keeps them",
        from.string(), its_kernel, world.bed->kernel_name(), its_kernel);
}

/// Likewise, and of the state itself.
void look_at_origin(const SavedRun& saved, const World& world, const std::filesystem::path& from) {
  look_at_program(saved.version, saved.kernel, world, from);
  if (!saved.exact)
    spdlog::warn(
        "warning: {} was written in a hurry, between two instants at which the machine can be taken up with its "
        "last digits",
        from.string());
}

/// The step of the run that is gone on with: chosen anew it would come out otherwise, of spheres that have moved.
void keep_step(World& world, const Loaded& loaded, const SavedRun& saved, const RunRequest& request) {
  if (!world.bed || !(saved.soil_step > 0) || loaded.scenario.time.soil_step || !request.changes.empty()) return;
  if (!(saved.soil_step < world.step.limit.step)) {
    spdlog::warn(
        "warning: the soil step of the state, {:.4g} s, is not stable at the speeds there: the run continues with "
        "{:.4g} "
        "s; give `time.soil step` to the run from its start for the same steps throughout",
        saved.soil_step, world.step.soil_step);
    return;
  }
  use_soil_step(world, loaded.scenario, saved.soil_step);
}

bool writes_parts(const FrameParts& parts, const Scenario& scenario) {
  return scenario.output.frames == FrameFiles::parts ||
         (scenario.output.frames == FrameFiles::automatic && parts.count() > 1);
}

/// The engine that the scenario asks for, and refusals of what it cannot do.
void use_engine(World& world, const Loaded& loaded, const RunRequest& request) {
  if (loaded.scenario.engine == SoilEngine::subsoil) return;
  try {
    std::unique_ptr<dem::BedEngine> engine = request.engine(request, loaded, world);
    auto* const parts = dynamic_cast<FrameParts*>(engine.get());
    if (parts != nullptr && writes_parts(*parts, loaded.scenario)) world.frame_parts = parts;
    world.bed->step_by(std::move(engine));
  } catch (const std::invalid_argument& error) {
    throw ScenarioError(
        fmt::format("{} = liggghts: {}; leave it out, or leave `engine` out", loaded.where("engine"), error.what()));
  }
}

/// What watches columns that are not there, before a bed settles for minutes.
void refuse_columns(const Loaded& loaded) {
  const Scenario& s = loaded.scenario;
  if (s.soil && s.soil->bed && s.soil->bed->settles()) static_cast<void>(place_and_list_columns(loaded));
}

/// What is known of the scenario that wrote the state only: which spheres rest, the past rates of a multistep method,
/// and the energy that the balance starts from, to which the change itself may add.
void begin_changed(const Scenario& s, World& world) {
  if (s.soil && s.soil->active) world.bed->set_active(active_rule(*s.soil->active));
  if (!world.machine) return;
  mbd::Snapshot state = world.machine->snapshot();
  state.past.rates.clear();
  state.energy_at_start += world.machine->energy().balance();
  world.machine->restore(state);
}

/// The run as asked for, in a folder that is locked.
int run_locked(const RunRequest& request, Loaded& loaded, std::optional<SavedRun>& saved, bool goes_on,
               const std::vector<Difference>& found, FolderLock& lock,
               const std::optional<SavedSettling>& settling_from = std::nullopt) {
  BuildOptions options;
  options.threads = use_threads(loaded, request.threads);
  options.place_soil = !saved;
  if (saved) options.restored = spheres_of(*saved);
  if (saved && saved->moving) options.moving = saved->moving.get();
  std::optional<Scenario> begun;
  if (saved && !begun_by(*saved).empty() &&
      drivers_differ(differences(begun_by(*saved), write_scenario(loaded.scenario)))) {
    begun = load_scenario_text(begun_by(*saved), request.from.string()).scenario;
    options.machine_start = {.begun_by = &*begun, .time = saved->time};
  }
  LiveLine settling;
  const SignalGuard guard;  // from here on a signal ends in an orderly way, also while the bed settles
  bool writes_settling = false;
  options.progress = [&, first = true](double time, double rms) mutable {
    // What `resume` begins again where a run is killed before it keeps its settling. A folder with results has its own.
    if (first && !std::filesystem::exists(request.out / "series.csv"))
      write_atomically(request.out / "scenario.yaml", write_scenario(loaded.scenario)), writes_settling = true;
    if (std::exchange(first, false) || settling.due())
      settling.show(fmt::format("settling: {:.3f} s, rms speed {:.2g} m/s", time, rms));
    return caught_signal() == 0;
  };
  SettlingCheckpoint checkpoint(request.out, write_scenario(loaded.scenario));
  options.settling = settling_from ? &settling_from->state : nullptr;
  options.keep_settling_due = [&] { return checkpoint.due(); };
  options.keep_settling = [&](const dem::SettleState& state, const dem::Bed& bed) {
    checkpoint.keep(state, bed.kernel_name());
  };
  if (!saved && !settling_from) refuse_columns(loaded);
  World world = [&] {
    try {
      return build_world(loaded, options);
    } catch (const ScenarioError&) {  // a refusal leaves nothing
      if (writes_settling)
        SettlingCheckpoint::remove(request.out), std::filesystem::remove(request.out / "scenario.yaml");
      throw;
    }
  }();
  if (saved) keep_step(world, loaded, *saved, request), continue_drivers(world, *saved, found, request.from.string());
  settling.close();
  if (!saved) report_soil(world);
  say_dense_frames(loaded, world);
  if (world.bed)
    spdlog::info("soil step {:.4g} s = {:.2f} of the stable step {:.4g} s ({})", world.step.soil_step,
                 world.step.soil_step / world.step.limit.step, world.step.limit.step, world.step.limit.cause);
  if (world.bed) spdlog::info("{}", accuracy_words(world.step));
  add_sphere_forces(world, loaded, request.sphere_forces);
  use_engine(world, loaded, request);
  if (goes_on) look_at_origin(*saved, world, request.from);
  if (settling_from) look_at_program(settling_from->version, settling_from->instruction_set, world, "settling.h5");
  Stepper stepper(loaded, std::move(world), saved ? &*saved : nullptr);
  if (saved) report_soil(stepper.world());  // before, spheres stood at the datum and the container did not
  if (!request.changes.empty()) begin_changed(loaded.scenario, stepper.world());
  return RunLoop(loaded, request, stepper, saved, lock, goes_on).run();
}

/// Whether a folder's run has reached its end, as its summary says.
bool has_ended(const std::filesystem::path& folder) {
  const Json json = read_json_if_whole(folder / "summary.json");
  return json.is_object() && json.contains("run") && json["run"].is_object() &&
         json["run"].value("end", "") == "reached";
}

/// The latest state of a folder that is whole and of a time before `end`, with its path; none: {}. A run that was cut
/// off between its last state and its summary is taken up before that state, and ends with the same bits.
std::optional<SavedRun> latest_whole_state(const std::filesystem::path& folder, double end,
                                           std::filesystem::path& path) {
  for (const std::filesystem::path& file : states_in(folder)) {
    try {
      SavedRun saved = read_run(file);
      if (!saved.progress || saved.time >= end) continue;
      path = file;
      return saved;
    } catch (const StateFault& error) {
      spdlog::warn("warning: {}; the one before is taken", error.what());
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<SeriesColumn> place_and_list_columns(const Loaded& loaded) {
  World world;
  try {
    BuildOptions options;
    options.threads = 1, options.settle = false;
    world = build_world(loaded, options);
  } catch (const std::exception&) {
    return {};  // the bed as placed meets something that the settled one may not
  }
  coupling::Simulation simulation(world.bed.get(), world.machine.get(), world.body_surfaces, world.motions,
                                  {.soil_step = world.step.soil_step,
                                   .soil_steps = static_cast<int>(loaded.scenario.time.machine.soil_steps),
                                   .machine_step = world.step.machine_step});
  const Columns columns(loaded, world, simulation);
  const Crossings crossings(loaded, columns);
  return columns.list();
}

int run(const RunRequest& given) {
  RunRequest request = given;
  if (request.out.empty()) request.out = std::filesystem::path(request.scenario).stem();
  if (!request.changes.empty() && request.from.empty())
    throw std::invalid_argument(fmt::format(
        "--change {}: names what differs from the scenario of a state; give --from STATE, or --set for another value",
        request.changes.front()));
  Loaded loaded = load_scenario(request.scenario, request.sets);
  if (!request.engine) go_on_as_engine(loaded);
  refuse_folder(request.out, request.force);
  FolderLock lock(request.out);
  if (!loaded.scenario.runs_in_time()) return run_analysis(loaded, request);
  std::optional<SavedRun> saved;
  std::vector<Difference> found;
  if (!request.from.empty()) {
    saved = read_state(request.from);
    refuse_other(*saved, loaded.scenario, request.from);
    found = look_at_changes(*saved, loaded, request);
  }
  SettlingCheckpoint::remove(request.out);
  return run_locked(request, loaded, saved, false, found, lock);
}

int resume(const std::filesystem::path& folder, const RunRequest& given) {
  const std::filesystem::path scenario = folder / "scenario.yaml";
  if (!std::filesystem::exists(scenario))
    throw ScenarioError(folder.string() + ": holds no scenario.yaml, so no run to continue; name the folder of one");
  if (has_ended(folder)) {
    if (std::filesystem::exists(folder / "run.lock")) {  // cut off between its summary and its end
      const FolderLock lock(folder);
      Checkpoints(folder).remove();
    }
    spdlog::info("{}: the run has reached its end", folder.string());
    return exit_ok;
  }
  RunRequest request = given;
  request.scenario = scenario.string(), request.out = folder;
  Loaded loaded = load_scenario(request.scenario, request.sets);
  if (!request.engine) go_on_as_engine(loaded);
  FolderLock lock(folder);
  std::optional<SavedRun> saved;
  // A machine alone is run again from its start: that takes seconds, and its integrators have more past than a state.
  if (loaded.scenario.has_bed()) saved = latest_whole_state(folder, loaded.scenario.time.end, request.from);
  if (saved) {
    refuse_other(*saved, loaded.scenario, request.from);
    const std::vector<Difference> found = look_at_changes(*saved, loaded, request);
    spdlog::info("going on from {} at {:.6g} s", request.from.filename().string(), saved->time);
    return run_locked(request, loaded, saved, true, found, lock);
  }
  const std::optional<SavedSettling> settling = SettlingCheckpoint(folder, write_scenario(loaded.scenario)).read();
  if (settling)
    spdlog::info("going on from settling.h5, a bed on its way to rest");
  else
    spdlog::info("no state to continue from in {}: from the start", folder.string());
  return run_locked(request, loaded, saved, false, {}, lock, settling);
}

}  // namespace subsoil::sim
