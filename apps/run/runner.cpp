#include "apps/run/runner.hpp"

#include <fmt/format.h>
#include <omp.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <csignal>
#include <memory>
#include <utility>

#include "apps/build/world.hpp"
#include "apps/output/atomic_file.hpp"
#include "apps/output/csv.hpp"
#include "apps/output/summary.hpp"
#include "apps/run/analysis.hpp"
#include "apps/run/columns.hpp"
#include "apps/run/frames.hpp"
#include "apps/run/live_line.hpp"
#include "apps/run/process.hpp"
#include "apps/run/restart.hpp"
#include "apps/run/tool.hpp"
#include "apps/version.hpp"

namespace subsoil::app {
namespace {

volatile std::sig_atomic_t caught_signal = 0;
void on_signal(int signal) { caught_signal = signal; }

/// Catches SIGINT and SIGTERM for the time of a run; a second one of the same kind ends the program at once.
class SignalGuard {
 public:
  SignalGuard() {
    caught_signal = 0;
    struct sigaction action {};
    action.sa_handler = on_signal;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(SIGINT, &action, &old_int_);
    sigaction(SIGTERM, &action, &old_term_);
  }
  ~SignalGuard() {
    sigaction(SIGINT, &old_int_, nullptr);
    sigaction(SIGTERM, &old_term_, nullptr);
  }

 private:
  struct sigaction old_int_ {
  }, old_term_{};
};

// Beyond these a run is no answer to trust: shares of the energy and of the machine's length and speed.
constexpr double most_closure = 1e-3, most_step_error = 1e-3;

/// Times at which something is due, a step early or late by no more than half a step.
class Schedule {
 public:
  Schedule(double every, std::vector<double> at, double from) : every_(every), at_(std::move(at)) {
    std::sort(at_.begin(), at_.end());
    while (next_at_ < at_.size() && at_[next_at_] < from) ++next_at_;
    if (every_ > 0) count_ = static_cast<long>(std::ceil(from / every_ - 1e-9));
  }
  bool due(double time, double half_step) {
    bool is = false;
    while (next_at_ < at_.size() && time >= at_[next_at_] - half_step) ++next_at_, is = true;
    while (every_ > 0 && time >= static_cast<double>(count_) * every_ - half_step) ++count_, is = true;
    return is;
  }

 private:
  double every_;
  std::vector<double> at_;
  std::size_t next_at_ = 0;
  long count_ = 0;
};

class Runner {
 public:
  Runner(const Loaded& loaded, const RunRequest& request, World world, const std::optional<SavedRun>& saved)
      : loaded_(loaded),
        s_(loaded.scenario),
        request_(request),
        world_(std::move(world)),
        simulation_(world_.bed.get(), world_.machine.get(), world_.body_surfaces, world_.motions,
                    {.soil_step = world_.step.soil_step,
                     .soil_steps = static_cast<int>(s_.time.machine.soil_steps),
                     .machine_step = world_.step.machine_step}) {
    if (saved) restore(*saved, world_, simulation_);
    columns_ = std::make_unique<Columns>(loaded_, world_, simulation_);
    tool_ = std::make_unique<ToolProgress>(world_);
    start_time_ = simulation_.time();
    if (world_.machine) machine_potential_start_ = world_.machine->energy().potential;
  }

  int run() {
    open_output();
    const int code = loop();
    finish(code);
    return code;
  }

 private:
  void open_output() {
    std::filesystem::create_directories(request_.out);
    write_atomically(request_.out / "scenario.yaml", write_scenario(s_));
    series_ = std::make_unique<SeriesWriter>(request_.out / "series.csv", columns_->list(),
                                             world_.bed ? 9 : csv::exact_digits);
    std::vector<SeriesColumn> summarised;
    for (const std::size_t c : columns_->summarised()) summarised.push_back(columns_->list()[c]);
    summary_ = std::make_unique<Summary>(summarised);
    summarised_.resize(summarised.size());
    row_.assign(columns_->list().size(), 0.0);
    values_ = row_;
    means_ = std::make_unique<IntervalMean>(row_.size());
    if (world_.machine)
      for (const std::string& group : world_.machine->assembly().redundant)
        summary_->warn(group + ": of their reactions those of least norm are reported");
    set_fixed_window();
    frames_ = std::make_unique<FrameOutput>(request_.out, s_, world_, simulation_);
  }

  void set_fixed_window() {
    const Window& w = s_.output.window;
    if (w.from || w.until)
      summary_->set_window(w.from.value_or(0), w.until.value_or(s_.time.end), "given in output.window");
    else if (!tool_->exists())
      summary_->set_window(start_time_, s_.time.end, "no tool passes through soil: the whole run");
    else
      window_pending_ = true;
    if (!tool_->exists()) return;
    const double entry = start_time_ + 0.9 * tool_->time_to_soil();
    for (const SurfaceRecord& r : world_.surfaces)
      if (r.owner == SurfaceRecord::Owner::container && world_.bed->boundary(r.boundary).active)
        summary_->share_of(r.name + ".Fx", "soil.draft", start_time_,
                           std::max(entry, start_time_ + world_.step.soil_step));
  }

  int loop() {
    // Without soil nothing is learnt of an instant by the step that leaves it: the last row needs no step.
    const bool step_tells = world_.bed != nullptr || columns_->has_means();
    const double dt = simulation_.step_length(), end = s_.time.end, half = 0.5 * dt;
    const double close = world_.bed ? half : 1e-6 * dt;
    if (!world_.bed) simulation_.end_at(end);
    Schedule frame_due(frame_interval(s_), s_.output.at, start_time_),
        sample_due(s_.output.series_every, {}, start_time_),
        state_due(s_.output.state_every.value_or(0), {}, start_time_ + half);
    while (true) {
      const double t = reached_ = simulation_.time();
      const int signal = caught_signal;
      const bool last = t >= end - close || signal != 0;
      const bool frame = frame_due.due(t, half) || last;
      const bool sample = sample_due.due(t, half) || last;
      // A bed on its way to rest is no state to go on from: a restart does not settle.
      if (!world_.soil.stopped && (state_due.due(t, half) || (last && (s_.output.state == State::full || signal != 0))))
        save_run(request_.out, world_, simulation_);
      if (sample || columns_->needs_every_step()) columns_->take_instant(values_);
      open_window(t);
      dem::Snapshot* const snapshot = frame ? frames_->begin() : nullptr;
      if (!last || step_tells) {
        if (!step(sample, snapshot)) return exit_failed;
        if (step_tells) columns_->take_step(values_, sample);
      }
      if (sample) write_row();
      if (sample && energy_is_lost()) return exit_failed;
      if (frame) frames_->write(t, steps_);
      if (last) return signal == SIGINT ? exit_interrupted : signal == SIGTERM ? exit_terminated : exit_ok;
      count_step(t, world_.bed ? dt : simulation_.time() - t);
      if (live_.due()) live_.show(live_text(row_));
    }
  }

  void write_row() {
    row_ = values_;
    if (steps_ > 0) {
      const std::vector<double>& mean = means_->take();
      for (std::size_t c = 0; c < row_.size(); ++c)
        if (columns_->is_mean(c)) row_[c] = mean[c];
    }
    series_->write(row_);
    track_energy(steps_ == 0);
  }

  /// Whether the machine's energy balance is off by more than it may; failure_ then says so.
  bool energy_is_lost() {
    if (!world_.machine) return false;
    const mbd::EnergyBook e = world_.machine->energy();
    if (e.closure() <= s_.limits.energy) return false;
    failure_ = fmt::format(
        "t = {:.9g} s: the energy balance of the machine is off by {:.3g} J, {:.2g} of the {:.3g} J there or moved, "
        "above "
        "limits.energy = {:g}; the step is too long for the motion, or a driver or force jumps. Leave out "
        "time.machine.step, shorten it, or raise the limit",
        reached_, e.balance(), e.closure(), e.moved, s_.limits.energy);
    return true;
  }

  /// The step from t on of length `taken` enters the means and the summary.
  void count_step(double t, double taken) {
    if (columns_->has_means()) means_->add(taken, values_);
    for (std::size_t c = 0; c < summarised_.size(); ++c) summarised_[c] = values_[columns_->summarised()[c]];
    summary_->sample(t + taken, taken, summarised_);
    if (world_.bed) {
      deepest_ = std::max(deepest_, world_.bed->max_overlap());
      fastest_ = std::max(fastest_, world_.bed->max_speed());
    }
    ++steps_;
  }

  /// False when the step cannot be taken; failure_ then says why.
  bool step(bool energy, dem::Snapshot* snapshot) {
    try {
      simulation_.step({.energy = energy, .snapshot = snapshot});
      return true;
    } catch (const std::exception& error) {
      failure_ = error.what();
      if (failure_.rfind("t = ", 0) != 0) failure_ = fmt::format("t = {:.9g} s: {}", reached_, failure_);
      return false;
    }
  }

  void open_window(double t) {
    if (!window_pending_) return;
    const std::optional<double> lasts = tool_->window_opens();
    if (!lasts) return;
    window_pending_ = false;
    summary_->set_window(
        t, t + *lasts,
        "from when the tool has travelled its length in soil plus its depth, until its tip is one depth "
        "from the far face");
  }

  std::string live_text(std::span<const double> row) const {
    const double t = simulation_.time(), share = (t - start_time_) / (s_.time.end - start_time_);
    const double wall = live_.elapsed();
    std::string text = fmt::format("t {:.4f} s  {:.1f} %", t, 100 * share);
    if (world_.bed)
      text += fmt::format("  {:.2f} M particle-steps/s", static_cast<double>(world_.bed->spheres().size()) *
                                                             static_cast<double>(steps_) / wall * 1e-6);
    text += "  remaining " + clock_text(wall / share * (1 - share));
    if (const int pull = columns_->find("pull"); pull >= 0)
      text += fmt::format("  pull {:.0f} N", row[static_cast<std::size_t>(pull)]);
    if (const int draft = columns_->find("soil.draft"); draft >= 0)
      text += fmt::format("  draft {:.0f} N", row[static_cast<std::size_t>(draft)]);
    return text;
  }

  /// The parts of the energy book that the summary closes; bed terms are of the last sampled step.
  void track_energy(bool first) {
    if (world_.bed && first) bed_start_ = world_.bed->energy().total() - world_.bed->energy().boundary_work;
    if (world_.bed && first) bed_gravity_start_ = world_.bed->energy().gravity;
  }

  void write_energy() {
    auto& e = summary_->section("energy");
    double error = 0, put_in = 0;
    const auto take_in = [&](const char* name, double work) {
      e[name] = work;
      put_in += std::abs(work);
    };
    if (world_.bed) {
      const dem::BedEnergy& b = world_.bed->energy();
      const double closure = b.total() - b.boundary_work - bed_start_;
      double given = 0;
      for (const coupling::GivenMotion& m : world_.motions) given += world_.bed->boundary(m.boundary).work;
      take_in("work of given motions [J]", given);
      take_in("gravity on the soil [J]", bed_gravity_start_ - b.gravity);
      e["damped [J]"] = b.lost.damping;
      e["slid [J]"] = b.lost.sliding;
      e["rolled [J]"] = b.lost.rolling;
      if (world_.bed->has_bonding_laws()) e["broken bonds [J]"] = b.lost.breaking;
      e["bed closure [J]"] = closure;
      error += closure;
    }
    if (world_.machine) {
      const mbd::EnergyBook m = world_.machine->energy();
      take_in("work of drivers [J]", m.driver_work);
      take_in("work of applied forces [J]", m.force_work);
      take_in("gravity on the machine [J]", machine_potential_start_ - m.potential);
      e["lost in the machine [J]"] = m.lost;
      e["machine closure [J]"] = m.balance();
      e["machine energy there or moved [J]"] = m.moved;
      e["machine closure over energy there or moved"] = m.closure();
      if (m.closure() > most_closure)
        warn(
            fmt::format("the machine's energy balance is off by {:.2g} of the energy there or moved: its motion is not "
                        "resolved; shorten the machine step or its tolerance",
                        m.closure()));
      error += m.balance();
    }
    if (world_.bed && world_.machine) {
      const coupling::InterfaceWork work = simulation_.interface_work();
      e["interface, on the soil [J]"] = work.on_soil;
      e["interface, on the machine [J]"] = work.on_machine;
      e["interface error [J]"] = work.error();
      error += work.error();
    }
    e["closure [J]"] = error;
    e["work put in [J]"] = put_in;
    e["closure over work put in"] = put_in > 0 ? error / put_in : 0.0;
  }

  /// Into the summary, and to the user's eye.
  void warn(const std::string& text) {
    summary_->warn(text);
    spdlog::warn("{}", text);
  }

  /// Of contacts at the speeds that were met.
  void warn_of_coarse_contacts() {
    const double speed = std::max(fastest_, world_.step.expected_speed), error = world_.step.error_at(speed);
    summary_->section("run")["error of restitution"] = error;
    if (error <= 1.2 * s_.time.accuracy + 1e-3) return;
    const auto fine = world_.step.at_speed(speed, s_.time.accuracy, world_.step.soil_step);
    warn(
        fmt::format("impacts at {:.3g} m/s, as met or expected, have a restitution wrong by up to {:.2g} "
                    "with the step of {:.3g} s; {:.3g} s would keep `time.accuracy: {:.3g}`",
                    speed, error, world_.step.soil_step, fine.step, s_.time.accuracy));
  }

  /// What fixed machine steps are estimated to err by.
  void write_step_error() {
    const mbd::StepError& error = world_.machine->integrator().step_error();
    if (error.fastest == 0) return;
    summary_->section("run")["machine step error"] = {{"largest of a step", error.largest}, {"sum", error.sum()}};
    if (error.sum() > most_step_error)
      warn(
          fmt::format("machine steps of {:.3g} s are estimated to err by {:.2g} of the machine's length and speed over "
                      "the run; shorten them{}",
                      world_.step.machine_step, error.sum(),
                      world_.bed ? " by fewer soil steps per machine step" : ", or leave out time.machine.step"));
  }

  void write_run_section(int code) {
    auto& r = summary_->section("run");
    r["version"] = version();
    r["scenario"] = std::filesystem::absolute(request_.scenario).string();
    r["title"] = s_.title;
    if (!request_.sets.empty()) r["set"] = request_.sets;
    r["end"] = code == exit_ok ? "reached" : code == exit_failed ? "failed" : "interrupted";
    if (!failure_.empty()) r["failure"] = failure_;
    r["simulated [s]"] = code == exit_failed ? simulation_.time() : reached_;
    r["wall time [s]"] = live_.elapsed();
    r["peak memory [bytes]"] = peak_memory();
    r["steps"] = steps_;
    r["frames"] = frames_->count();
    if (world_.machine) r["machine step [s]"] = world_.step.machine_step;
    if (s_.analysis != Analysis::dynamics) r["analysis"] = analysis_names[static_cast<std::size_t>(s_.analysis)];
    if (!world_.bed) return;
    r["instruction set"] = world_.bed->kernel_name();
    r["precision"] = world_.bed->options().precision == dem::Precision::mixed ? "mixed" : "double";
    r["threads"] = world_.bed->threads();
    r["soil step [s]"] = world_.step.soil_step;
    r["soil step over stable step"] = world_.step.soil_step / world_.step.limit.step;
    r["stable step set by"] = world_.step.limit.cause;
    warn_of_coarse_contacts();
    r["neighbour builds"] = world_.bed->rebuilds();
    r["largest overlap [share of a radius]"] = deepest_;
    r["particle-steps per second"] =
        static_cast<double>(world_.bed->spheres().size()) * static_cast<double>(steps_) / live_.elapsed();
    auto& b = summary_->section("soil");
    b["spheres"] = world_.soil.spheres;
    b["mass [kg]"] = world_.soil.mass;
    b["bulk density [kg/m3]"] = world_.soil.bulk_density;
    b["mean surface [m]"] = world_.soil.surface_mean;
    b["spread of the surface [m]"] = world_.soil.surface_spread;
    b["contacts per sphere"] = world_.soil.coordination;
    for (const auto& [material, layer] : world_.soil.layers)
      b["layers"].push_back({{"material", material},
                             {"spheres", layer.spheres},
                             {"mass [kg]", layer.mass},
                             {"top [m]", layer.top},
                             {"spread of the top [m]", layer.spread},
                             {"thickness [m]", layer.thickness}});
    b["settled for [s]"] = world_.soil.settled_for;
    b["carved for the machine"] = world_.soil.carved;
    b["fallen out and removed"] = world_.bed->removed_count();
    b["outside the container at the end"] = outside();
    if (world_.bed->has_bonding_laws()) write_bonds();
  }

  void write_bonds() {
    const dem::BondCount n = world_.bed->bonds();
    summary_->section("bonds") = {{"formed", n.formed},
                                  {"intact", n.intact()},
                                  {"broken in tension", n.broken_in_tension},
                                  {"broken in shear", n.broken_in_shear},
                                  {"removed with spheres", n.removed}};
    spdlog::info("bonds: {} formed, {} intact, {} broken in tension, {} in shear", n.formed, n.intact(),
                 n.broken_in_tension, n.broken_in_shear);
    if (n.formed == 0)
      summary_->warn("a law has bonds but none formed: no spheres were within `bond gap` at `bond time`");
  }

  void write_events() {
    const std::vector<mbd::Event>& events = world_.machine->events();
    summary_->section("run")["events"] = events.size();
    if (events.empty()) return;
    spdlog::info("{} events, the first at {:.9g} s: {} {}", events.size(), events.front().t, events.front().name,
                 events.front().word());
    auto& list = summary_->section("events");
    list = nlohmann::ordered_json::array();
    for (const mbd::Event& e : events) list.push_back({{"time [s]", e.t}, {"of", e.name}, {"direction", e.word()}});
  }

  std::size_t outside() const {
    if (!s_.soil || !s_.soil->container) return 0;
    const Container& c = *s_.soil->container;
    std::size_t count = 0;
    for (const dem::Sphere& p : world_.bed->spheres()) {
      const Vec3 d = p.x - (c.at + Vec3{0, world_.container_shift, 0});
      if (d.x < 0 || d.x > c.size.x || d.z < 0 || d.z > c.size.z || d.y < 0) ++count;
    }
    return count;
  }

  void finish(int code) {
    live_.close();
    series_->flush();
    frames_->finish();
    if (world_.soil.stopped)
      summary_->warn("the run was interrupted while the bed settled: time 0 shows it on its way to rest");
    if (window_pending_) summary_->warn("the tool never reached steady work: no means; set output.window to take some");
    write_run_section(code);
    if (world_.machine) write_events();
    if (world_.machine) write_step_error();
    write_energy();
    summary_->write(request_.out / "summary.json");
    if (code == exit_failed) {
      spdlog::error("{}", failure_);
      spdlog::error("the run stops here; results up to then are in {}", request_.out.string());
    } else {
      spdlog::info("{} in {}; results in {}", code == exit_ok ? "done" : "interrupted", clock_text(live_.elapsed()),
                   request_.out.string());
    }
  }

  const Loaded& loaded_;
  const Scenario& s_;
  RunRequest request_;
  World world_;
  coupling::Simulation simulation_;
  std::unique_ptr<Columns> columns_;
  std::unique_ptr<ToolProgress> tool_;
  std::unique_ptr<SeriesWriter> series_;
  std::unique_ptr<Summary> summary_;
  std::unique_ptr<FrameOutput> frames_;
  std::unique_ptr<IntervalMean> means_;
  std::vector<double> values_, row_, summarised_;  // of the step, of the row written last, of the summary's columns
  LiveLine live_;
  std::string failure_;
  double start_time_ = 0, reached_ = 0;
  double bed_start_ = 0, bed_gravity_start_ = 0, machine_potential_start_ = 0;
  double deepest_ = 0, fastest_ = 0;
  long steps_ = 0;
  bool window_pending_ = false;
};

/// An existing directory that is not empty is not written over unless forced; then only a run's own files go.
void prepare_directory(const std::filesystem::path& out, bool force) {
  if (!std::filesystem::exists(out)) return;
  if (!std::filesystem::is_directory(out))
    throw ScenarioError(out.string() + ": is a file, results need a directory; choose another --out");
  if (std::filesystem::is_empty(out)) return;
  if (!force)
    throw ScenarioError(out.string() + ": exists and is not empty; choose another --out, or --force to write over it");
}

void report_soil(const World& world) {
  if (!world.bed || world.soil.spheres == 0) return;
  spdlog::info(
      "soil: {} spheres, {:.1f} kg, bulk density {:.0f} kg/m3, surface at {:.4f} m (spread {:.1f} mm), {:.2f} contacts "
      "per sphere",
      world.soil.spheres, world.soil.mass, world.soil.bulk_density, world.soil.surface_mean,
      world.soil.surface_spread * 1e3, world.soil.coordination);
  for (const auto& [material, layer] : world.soil.layers)
    spdlog::info("layer of {}: {} spheres, {:.1f} mm thick, top at {:.4f} m (spread {:.1f} mm)", material,
                 layer.spheres, layer.thickness * 1e3, layer.top, layer.spread * 1e3);
  if (world.soil.settled_for > 0)
    spdlog::info("settled for {:.3f} s to an rms speed of {:.2g} m/s", world.soil.settled_for, world.soil.rms_speed);
  if (world.soil.carved > 0) spdlog::info("{} spheres carved out for the machine", world.soil.carved);
}

}  // namespace

int run(const RunRequest& given) {
  RunRequest request = given;
  if (request.out.empty()) request.out = std::filesystem::path(request.scenario).stem();
  Loaded loaded = load_scenario(request.scenario, request.sets);
  prepare_directory(request.out, request.force);
  if (!loaded.scenario.runs_in_time()) return run_analysis(loaded, request);
  std::optional<SavedRun> saved;
  if (!request.from.empty()) {
    saved = read_run(request.from);
    refuse_other(*saved, loaded.scenario, request.from);
  }
  BuildOptions options;
  options.threads = request.threads > 0 ? request.threads : static_cast<int>(loaded.scenario.time.threads);
  if (options.threads > 0) omp_set_num_threads(options.threads);  // of output too
  options.place_soil = !saved;
  if (saved) options.restored = spheres_of(*saved);
  LiveLine settling;
  const SignalGuard guard;  // from here on a signal ends in an orderly way, also while the bed settles
  options.progress = [&, first = true](double time, double rms) mutable {
    if (std::exchange(first, false) || settling.due())
      settling.show(fmt::format("settling: {:.3f} s, rms speed {:.2g} m/s", time, rms));
    return caught_signal == 0;
  };
  World world = build_world(loaded, options);
  settling.close();
  report_soil(world);
  if (world.bed)
    spdlog::info("soil step {:.4g} s = {:.2f} of the stable step {:.4g} s ({})", world.step.soil_step,
                 world.step.soil_step / world.step.limit.step, world.step.limit.step, world.step.limit.cause);
  if (world.bed) spdlog::info("{}", accuracy_words(world.step));
  return Runner(loaded, request, std::move(world), saved).run();
}

}  // namespace subsoil::app
