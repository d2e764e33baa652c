#include "apps/run/runner.hpp"

#include <fmt/format.h>
#include <omp.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "apps/build/world.hpp"
#include "apps/output/atomic_file.hpp"
#include "apps/output/csv.hpp"
#include "apps/output/disk.hpp"
#include "apps/output/series_file.hpp"
#include "apps/output/state_file.hpp"
#include "apps/output/summary.hpp"
#include "apps/run/analysis.hpp"
#include "apps/run/columns.hpp"
#include "apps/run/continuation.hpp"
#include "apps/run/frames.hpp"
#include "apps/run/input_report.hpp"
#include "apps/run/live_line.hpp"
#include "apps/run/output_folder.hpp"
#include "apps/run/overlap_advice.hpp"
#include "apps/run/restart.hpp"
#include "apps/run/resume.hpp"
#include "apps/run/run_summary.hpp"
#include "apps/run/surface_report.hpp"
#include "apps/run/tool.hpp"
#include "apps/run/wall_watch.hpp"
#include "apps/version.hpp"

namespace subsoil::app {
namespace {

double checkpoint_interval = 600;  // s

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
  Schedule() = default;
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
  void archive(Archive& a) { a(next_at_, count_); }

 private:
  double every_ = 0;
  std::vector<double> at_;
  std::size_t next_at_ = 0;
  long count_ = 0;
};

class Runner {
 public:
  Runner(const Loaded& loaded, const RunRequest& request, World world, const std::optional<SavedRun>& saved,
         FolderLock& lock, bool goes_on)
      : loaded_(loaded),
        s_(loaded.scenario),
        request_(request),
        lock_(lock),
        world_(std::move(world)),
        simulation_(world_.bed.get(), world_.machine.get(), world_.body_surfaces, world_.motions,
                    {.soil_step = world_.step.soil_step,
                     .soil_steps = static_cast<int>(s_.time.machine.soil_steps),
                     .machine_step = world_.step.machine_step}) {
    if (saved) restore(*saved, world_, simulation_);
    if (saved) refuse_jumps(world_, simulation_.time(), request_.from.string());
    columns_ = std::make_unique<Columns>(loaded_, world_, simulation_);
    tool_ = std::make_unique<ToolProgress>(world_, simulation_, s_.time.end);
    start_time_ = simulation_.time();
    if (world_.machine) energy_start_.machine_potential = world_.machine->energy().potential;
    restores_ = world_.bed != nullptr;
    if (goes_on) go_on_ = &*saved->progress;
  }

  int run() {
    open_output();
    int code = exit_failed;
    try {
      code = loop();
    } catch (const std::exception& error) {  // of what is written: steps say themselves why they fail
      failure_ = fmt::format("t = {:.9g} s: {}", reached_, error.what());
    }
    finish(code);
    return code == exit_ok && request_.strict && !summary_->warnings().empty() ? exit_failed : code;
  }

 private:
  void open_output() {
    if (go_on_ == nullptr) {
      remove_results(request_.out, request_.from);
      write_atomically(request_.out / "scenario.yaml", write_scenario(s_));
    }
    series_ = std::make_unique<SeriesFile>(request_.out / "series.csv", columns_->list(),
                                           world_.bed ? 9 : csv::exact_digits, kept_bytes());
    std::vector<SeriesColumn> summarised;
    for (const std::size_t c : columns_->summarised()) summarised.push_back(columns_->list()[c]);
    summary_ = std::make_unique<Summary>(summarised);
    summarised_.resize(summarised.size());
    row_.assign(columns_->list().size(), 0.0);
    values_ = row_;
    means_ = std::make_unique<RowMean>(row_.size());
    if (world_.machine)
      for (const std::string& group : world_.machine->assembly().redundant)
        spdlog::info("{}: of their reactions those of least norm are reported", group);
    set_fixed_window();
    for (const std::string& text : surface_warnings(surface_facts(world_, s_.time.end), world_)) warn(text);
    for (const std::string& text : input_warnings(loaded_, world_, request_.scenario, request_.sets)) warn(text);
    frames_ = std::make_unique<FrameOutput>(request_.out, s_, world_, simulation_, go_on_);
    const double half = 0.5 * simulation_.step_length();
    frame_due_ = Schedule(frame_interval(s_), s_.output.at, start_time_);
    sample_due_ = Schedule(s_.output.series_every, {}, start_time_);
    state_due_ = Schedule(s_.output.state_every.value_or(0), {}, start_time_ + half);
    if (go_on_ == nullptr) return;
    Archive sums = go_on_->sums;
    archive(sums);
    sums.end();
  }

  /// Of series.csv, where the run goes on in its folder.
  std::optional<std::uint64_t> kept_bytes() const {
    if (go_on_ == nullptr) return std::nullopt;
    std::error_code fault;
    const auto size = std::filesystem::file_size(request_.out / "series.csv", fault);
    if (fault || size < go_on_->series_bytes)
      throw ScenarioError(fmt::format("{}: series.csv has lost rows that {} counts; start anew", request_.out.string(),
                                      request_.from.filename().string()));
    return go_on_->series_bytes;
  }

  /// All that the run has added up beside bed, machine and coupling.
  void archive(Archive& a) {
    a(frame_due_, sample_due_, state_due_, *summary_, *means_, *tool_, walls_);
    a(values_, row_, looks_, start_time_, deepest_, fastest_, steps_, window_);
    a(energy_start_.bed, energy_start_.bed_gravity, energy_start_.machine_potential);
    StepReport& step = world_.step;
    a(step.limit.step, step.limit.cause, step.expected_speed);
    a(step.accurate.step, step.accurate.error, step.accurate.contact, step.accurate.cause);
    archive_origin(a);
  }
  /// What the summary says of where the run came from.
  void archive_origin(Archive& a) {
    a(request_.scenario, request_.sets);
    bool strict = request_.strict;
    a(strict);
    request_.strict = request_.strict || strict;
  }

  void save(const std::filesystem::path& path) {
    RunProgress progress;
    archive(progress.sums);
    frames_->publish(progress);
    progress.series_bytes = series_->sync();
    require_space(path, state_bytes_ + state_bytes_ / 8);
    progress.exact = machine_is_fresh_ && restores_;
    save_run(path, s_, world_, simulation_, progress);
    std::error_code unknown;
    const auto bytes = std::filesystem::file_size(path, unknown);
    if (!unknown) state_bytes_ = std::max<std::uint64_t>(state_bytes_, bytes);
  }

  /// The two last ones stay: the one before in case that the disk damages the last.
  void save_checkpoint() {
    const std::filesystem::path path = checkpoint_path(request_.out, simulation_.time());
    save(path);
    checkpoint_at_ = Clock::now();
    std::vector<std::filesystem::path> kept;
    for (const std::filesystem::path& file : states_in(request_.out))
      if (file.filename().string().starts_with("checkpoint-")) kept.push_back(file);
    std::error_code ignored;
    for (std::size_t k = 2; k < kept.size(); ++k) std::filesystem::remove(kept[k], ignored);
  }

  /// Of a machine alone there is none: it is run again.
  bool checkpoint_is_due() const {
    return checkpoint_interval > 0 && restores_ && machine_is_fresh_ &&
           std::chrono::duration<double>(Clock::now() - checkpoint_at_).count() >= checkpoint_interval;
  }

  void remove_checkpoints() {
    std::error_code ignored;
    for (const std::filesystem::path& file : states_in(request_.out))
      if (file.filename().string().starts_with("checkpoint-")) std::filesystem::remove(file, ignored);
  }

  void set_fixed_window() {
    const Window& w = s_.output.window;
    if (w.from || w.until)
      summary_->set_window(w.from.value_or(0), w.until.value_or(s_.time.end), "given in output.window");
    else if (!tool_->any_passes())
      summary_->set_window(start_time_, s_.time.end, "no tool passes through soil: the whole run");
    else
      window_ = Opening::pending;
    const double period = period_of(s_);
    if (period > 0 && period < s_.time.end - start_time_) summary_->take_whole_periods(period);
    if (std::isnan(period)) warn("the given motions have no period in common: means are over the whole window");
  }

  /// Says it now and at the end, and writes it down.
  void warn(const std::string& text) {
    live_.close();
    spdlog::warn("warning: {}", text);
    summary_->warn(text);
  }

  int loop() {
    // Without soil nothing is learnt of an instant by the step that leaves it: the last row needs no step.
    const bool step_tells = world_.bed != nullptr || columns_->has_means();
    const double dt = simulation_.step_length(), end = s_.time.end, half = 0.5 * dt;
    const double close = world_.bed ? half : 1e-6 * dt;
    if (!world_.bed) simulation_.end_at(end);
    while (true) {
      const double t = reached_ = simulation_.time();
      const bool save_due = state_due_.due(t, half);
      refresh_machine(save_due);
      const int signal = signal_to_obey();
      const bool last = t >= end - close || signal != 0;
      // A bed on its way to rest is no state to go on from: a restart does not settle. Saved before anything else is
      // decided here: whoever goes on from the state begins with this line.
      if (!world_.soil.stopped) {
        if (save_due || (last && (s_.output.state == State::full || signal != 0)))
          save(state_path(request_.out, t));
        else if (!last && checkpoint_is_due())
          save_checkpoint();
      }
      const bool frame = frame_due_.due(t, half) || last;
      const bool sample = sample_due_.due(t, half) || last;
      if (sample || columns_->needs_every_step()) columns_->take_instant(values_);
      if (sample && world_.bed) follow_tools(t);
      dem::Snapshot* const snapshot = frame ? frames_->begin() : nullptr;
      if (!last || step_tells) {
        const bool first = steps_ == 0 && !energy_begun_;
        if (!step(sample || first, snapshot)) return exit_failed;
        if (first) begin_energy();
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

  /// A machine that is taken up from a state chooses its coordinates anew and factors its matrices where it stands,
  /// which moves the last digits. So the one that runs in soil does the same every so many steps, and wherever a state
  /// is due: a run that goes on from there has the same bits. Beside a singular pose it is left alone.
  void refresh_machine(bool state_due) {
    constexpr long every = 64;
    machine_is_fresh_ = world_.machine == nullptr;
    if (world_.machine == nullptr || !restores_ || !(state_due || steps_ % every == 0)) return;
    if (world_.machine->integrator().partition().near_singular()) return;
    // To a state that is its own restoration: joints are closed to rounding after one or two.
    constexpr int most = 4;
    std::vector<double> state = world_.machine->snapshot();
    for (int k = 0; k < most && !machine_is_fresh_; ++k) {
      world_.machine->restore(state);
      std::vector<double> again = world_.machine->snapshot();
      machine_is_fresh_ = again == state;
      state = std::move(again);
    }
  }

  /// A signal waits for an instant at which a state is exact, but not for long.
  int signal_to_obey() {
    const int signal = caught_signal;
    if (signal == 0) return 0;
    if (!signal_at_) signal_at_ = Clock::now();
    const bool waits = restores_ && !machine_is_fresh_ && Clock::now() - *signal_at_ < std::chrono::seconds(3);
    return waits ? 0 : signal;
  }

  void write_row() {
    row_ = values_;
    if (steps_ > 0) {
      const std::vector<double>& mean = means_->take();
      for (std::size_t c = 0; c < row_.size(); ++c)
        if (columns_->is_mean(c)) row_[c] = mean[c];
    }
    series_->write(row_);
  }

  /// Whether the machine's energy balance is off by more than it may; failure_ then says so.
  bool energy_is_lost() {
    if (!world_.machine) return false;
    const mbd::MachineEnergy e = world_.machine->energy();
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
      if (const std::string advice = overlap_advice(failure_, world_, s_); !advice.empty()) failure_ += "; " + advice;
      if (failure_.rfind("t = ", 0) != 0) failure_ = fmt::format("t = {:.9g} s: {}", reached_, failure_);
      return false;
    }
  }

  /// Opens and closes the window of the means where the tools' ways say so, and looks at the walls while it is open.
  void follow_tools(double t) {
    if (tool_->tools().empty()) return;
    tool_->follow();
    if (window_ == Opening::pending && tool_->steady() && !tool_->at_the_end()) {
      window_ = Opening::open;
      summary_->set_window(
          t, s_.time.end,
          "from when the tool has travelled, in soil, its length there plus its depth, until its foremost point is one "
          "depth from the end of the soil");
    } else if (window_ == Opening::open && tool_->at_the_end()) {
      window_ = Opening::closed;
      summary_->close_window(t);
    }
    if (!tool_->any_passes() || t < summary_->window_from() || t > summary_->window_until() + s_.output.series_every)
      return;
    if (!walls_.has_begun()) return walls_.begin(world_);
    if (++looks_ % 20 != 0) return;  // a look goes through all spheres
    for (const std::string& wall : walls_.look(world_))
      warn(fmt::format(
          "t = {:.4g} s: disturbed soil reaches {} ({:.0f} % of the spheres there have moved by half a radius "
          "since the means began); make the bin larger there",
          t, wall, 100 * WallWatch::share));
  }

  std::string live_text(std::span<const double> row) {
    const double t = simulation_.time(), share = (t - start_time_) / (s_.time.end - start_time_);
    const double wall = live_.elapsed();
    std::string text = fmt::format("t {:.4f} s  {:.1f} %", t, 100 * share);
    if (world_.bed)
      text += fmt::format("  {:.2f} M particle-steps/s", static_cast<double>(world_.bed->spheres().size()) *
                                                             static_cast<double>(steps_) / wall * 1e-6);
    text += "  remaining " + clock_text(rate_.remaining(wall, t, s_.time.end));
    if (const int pull = columns_->find("pull"); pull >= 0)
      text += fmt::format("  pull {:.0f} N", row[static_cast<std::size_t>(pull)]);
    if (const int draft = columns_->find("soil.draft"); draft >= 0)
      text += fmt::format("  draft {:.0f} N", row[static_cast<std::size_t>(draft)]);
    return text;
  }

  /// What the summary's energy balance starts from; the bed's terms are of the first step.
  void begin_energy() {
    energy_begun_ = true;
    if (!world_.bed) return;
    energy_start_.bed = world_.bed->energy().total() - world_.bed->energy().boundary_work;
    energy_start_.bed_gravity = world_.bed->energy().gravity;
  }

  /// Of contacts at the speeds that were met.
  void warn_of_coarse_contacts() {
    const double speed = std::max(fastest_, world_.step.expected_speed), error = world_.step.error_at(speed);
    write_restitution_error(*summary_, error);
    if (error <= 1.2 * s_.time.accuracy + 1e-3) return;
    const auto fine = world_.step.at_speed(speed, s_.time.accuracy, world_.step.soil_step);
    summary_->warn(
        fmt::format("impacts at {:.3g} m/s, as met or expected, have a restitution wrong by up to {:.2g} "
                    "with the step of {:.3g} s; {:.3g} s would keep `time.accuracy: {:.3g}`",
                    speed, error, world_.step.soil_step, fine.step, s_.time.accuracy));
  }

  /// What fixed machine steps are estimated to err by.
  void write_step_error() {
    const mbd::StepError& error = world_.machine->integrator().step_error();
    if (error.fastest == 0) return;
    app::write_step_error(*summary_, error);
    if (error.sum() > most_step_error)
      summary_->warn(
          fmt::format("machine steps of {:.3g} s are estimated to err by {:.2g} of the machine's length and speed over "
                      "the run; shorten them{}",
                      world_.step.machine_step, error.sum(),
                      world_.bed ? " by fewer soil steps per machine step" : ", or leave out time.machine.step"));
  }

  void warn_of_machine_energy() {
    if (!world_.machine) return;
    const double closure = world_.machine->energy().closure();
    if (closure > most_closure)
      summary_->warn(
          fmt::format("the machine's energy balance is off by {:.2g} of the energy there or moved: its motion is not "
                      "resolved; shorten the machine step or its tolerance",
                      closure));
  }

  /// What is left to be written after a failure of the disk is tried, each on its own.
  template <class Action>
  void attempt(int& code, const Action& action) {
    try {
      action();
    } catch (const std::exception& error) {
      if (code != exit_failed) failure_ = fmt::format("t = {:.9g} s: {}", reached_, error.what());
      code = exit_failed;
      lock_.free_reserve();
    }
  }

  void finish(int& code) {
    live_.close();
    if (code == exit_failed) lock_.free_reserve();
    attempt(code, [&] { series_->sync(); });
    attempt(code, [&] { frames_->finish(); });
    last_warnings(code);
    write_run_section(*summary_,
                      {.code = code,
                       .failure = failure_,
                       .reached = code == exit_failed ? simulation_.time() : reached_,
                       .wall_time = live_.elapsed(),
                       .steps = steps_,
                       .frames = frames_->count(),
                       .deepest = deepest_},
                      s_, request_, world_);
    if (world_.machine) write_events(*summary_, *world_.machine);
    write_energy(*summary_, energy_start_, world_, simulation_);
    if (!tool_->tools().empty()) write_tools(*summary_, *tool_);
    attempt(code, [&] { summary_->write(request_.out / "summary.json"); });
    if (code == exit_ok) remove_checkpoints();
    if (const std::string means = means_text(*summary_, *tool_, s_); !means.empty() && world_.bed)
      spdlog::info("{}", means.substr(0, means.size() - 1));
    for (const std::string& text : summary_->warnings()) spdlog::warn("warning: {}", text);
    if (code == exit_failed) {
      spdlog::error("{}", failure_);
      spdlog::error("the run stops here; results up to then are in {}", request_.out.string());
    } else {
      spdlog::info("{} in {}; results in {}", code == exit_ok ? "done" : "interrupted", clock_text(live_.elapsed()),
                   request_.out.string());
    }
  }

  /// What only the end of a run knows.
  void last_warnings(int code) {
    if (world_.bed) warn_of_coarse_contacts();
    if (world_.machine) write_step_error();
    warn_of_machine_energy();
    if (world_.soil.stopped)
      summary_->warn("the run was interrupted while the bed settled: time 0 shows it on its way to rest");
    if (world_.bed && world_.bed->has_bonding_laws() && world_.bed->bonds().formed == 0)
      summary_->warn("a law has bonds but none formed: no spheres were within `bond gap` at `bond time`");
    if (code != exit_ok) return;
    for (const Tool& tool : tool_->tools())
      if (!tool.touched)
        summary_->warn(
            fmt::format("{} touched no soil in the whole run: see where it starts and how it moves; `subsoil "
                        "check` says how far it is from the soil",
                        tool.name));
    if (window_ == Opening::pending)
      summary_->warn(
          "no tool came to steady work (its length in soil plus its depth of travel): no means; let it travel "
          "farther, or set output.window");
    else if (!std::isfinite(summary_->window_from()) || !(summary_->window_until() > summary_->window_from()))
      summary_->warn(
          "the window of the means was never reached, or is shorter than a period of the given motion: means "
          "are null; let it run longer, or set output.window");
  }

  const Loaded& loaded_;
  using Clock = std::chrono::steady_clock;  // a clock on the wall may be set back

  const Scenario& s_;
  RunRequest request_;
  FolderLock& lock_;
  const RunProgress* go_on_ = nullptr;  ///< what stands in the folder, to go on behind; null: from the start
  World world_;
  coupling::Simulation simulation_;
  std::unique_ptr<Columns> columns_;
  std::unique_ptr<ToolProgress> tool_;
  std::unique_ptr<SeriesFile> series_;
  std::unique_ptr<Summary> summary_;
  std::unique_ptr<FrameOutput> frames_;
  std::unique_ptr<RowMean> means_;
  std::vector<double> values_, row_, summarised_;  // of the step, of the row written last, of the summary's columns
  LiveLine live_;
  RecentRate rate_;
  WallWatch walls_;
  Schedule frame_due_, sample_due_, state_due_;
  Clock::time_point checkpoint_at_ = Clock::now();
  std::uint64_t state_bytes_ = 0;  ///< of the largest state so far
  bool energy_begun_ = false;
  bool restores_ = true;          ///< a run may go on from its states with the same bits
  bool machine_is_fresh_ = true;  ///< at this instant
  std::optional<Clock::time_point> signal_at_;
  long looks_ = 0;
  std::string failure_;
  double start_time_ = 0, reached_ = 0;
  EnergyStart energy_start_;
  double deepest_ = 0, fastest_ = 0;
  long steps_ = 0;
  enum class Opening { fixed, pending, open, closed } window_ = Opening::fixed;
};

/// More frames than steps would only be the same ones again. (Where nothing is said, there are as many as there can
/// be.)
void refuse_dense_frames(const Loaded& loaded, const World& world) {
  if (!loaded.scenario.output.every) return;
  const double step = world.bed ? world.step.soil_step : 1e-9, every = frame_interval(loaded.scenario);
  if (every > 0 && every < step)
    throw ScenarioError(
        fmt::format("{} = {:.3g} s: is shorter than the step of {:.3g} s; a frame per step would be "
                    "{:.3g} s, a movie needs some 10 ms",
                    loaded.where("output.every"), every, step, step));
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

/// What the scenario says otherwise than the one that wrote the state: listed, and refused where it must be.
void look_at_changes(const SavedRun& saved, const Loaded& loaded, const RunRequest& request) {
  if (saved.scenario.empty()) {
    spdlog::warn("warning: {} does not say which scenario wrote it: nothing was compared", request.from.string());
    return;
  }
  const std::vector<Difference> found = differences(saved.scenario, write_scenario(loaded.scenario));
  refuse_changes(found, request.changes, request.from.string());
  if (loaded.scenario.time.end <= saved.time)
    throw ScenarioError(fmt::format("{} = {:.6g} s: the state is of {:.6g} s; give a later end",
                                    loaded.where("time.end"), loaded.scenario.time.end, saved.time));
  for (const Difference& d : found)
    if (d.kind != Difference::Kind::harmless) spdlog::info("changed: {} from {} to {}", d.key, d.before, d.now);
}

/// Throws ScenarioError for a file that is no state, or a damaged one.
SavedRun read_state(const std::filesystem::path& file) {
  try {
    return read_run(file);
  } catch (const std::exception& error) {
    const std::string text = error.what();
    throw ScenarioError(text.find(file.string()) != std::string::npos ? text : file.string() + ": " + text);
  }
}

/// What keeps the end from being the same bits, said and no reason to stop.
void look_at_program(const SavedRun& saved, const World& world, const std::filesystem::path& from) {
  if (saved.version != version())
    spdlog::warn("warning: {} was written by version {}, this is {}: the end may differ in its last digits",
                 from.string(), saved.version, version());
  if (world.bed && saved.kernel != world.bed->kernel_name())
    spdlog::warn(
        "warning: {} was written with the instruction set {}, this run uses {}: the end may differ in its last "
        "digits; --simd {} keeps them",
        from.string(), saved.kernel, world.bed->kernel_name(), saved.kernel);
  if (!saved.exact)
    spdlog::warn(
        "warning: {} was written in a hurry, between two instants at which the machine can be taken up with its "
        "last digits",
        from.string());
}

/// The step of the run that is gone on with: chosen anew it would come out otherwise, of spheres that have moved.
void keep_step(World& world, const Loaded& loaded, const SavedRun& saved, const RunRequest& request) {
  if (!world.bed || !(saved.soil_step > 0) || loaded.scenario.time.soil_step || !request.changes.empty()) return;
  if (!(saved.soil_step < world.step.limit.step)) return;
  world.step.soil_step = saved.soil_step;
  world.step.machine_step = saved.soil_step * static_cast<double>(loaded.scenario.time.machine.soil_steps);
}

/// The run as asked for, in a folder that is locked.
int run_locked(const RunRequest& request, Loaded& loaded, const std::optional<SavedRun>& saved, bool goes_on,
               FolderLock& lock) {
  BuildOptions options;
  options.threads = request.threads > 0 ? request.threads : static_cast<int>(loaded.scenario.time.threads);
  if (!loaded.scenario.has_bed() && options.threads == 0) options.threads = 1;  // a machine alone has no work for more
  if (options.threads > 0) omp_set_num_threads(options.threads);                // of output too
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
  if (saved) keep_step(world, loaded, *saved, request);
  settling.close();
  report_soil(world);
  refuse_dense_frames(loaded, world);
  if (world.bed)
    spdlog::info("soil step {:.4g} s = {:.2f} of the stable step {:.4g} s ({})", world.step.soil_step,
                 world.step.soil_step / world.step.limit.step, world.step.limit.step, world.step.limit.cause);
  if (world.bed) spdlog::info("{}", accuracy_words(world.step));
  if (goes_on) look_at_program(*saved, world, request.from);
  return Runner(loaded, request, std::move(world), saved, lock, goes_on).run();
}

/// Whether a folder's run has reached its end, as its summary says.
bool has_ended(const std::filesystem::path& folder) {
  std::ifstream file(folder / "summary.json");
  const auto json = nlohmann::json::parse(file, nullptr, false);
  return json.is_object() && json.contains("run") && json["run"].is_object() &&
         json["run"].value("end", "") == "reached";
}

/// The latest state of a folder that is whole, with its path; none: {}.
std::optional<SavedRun> latest_whole_state(const std::filesystem::path& folder, std::filesystem::path& path) {
  for (const std::filesystem::path& file : states_in(folder)) {
    try {
      SavedRun saved = read_run(file);
      if (!saved.progress) continue;
      path = file;
      return saved;
    } catch (const std::exception& error) {
      spdlog::warn("warning: {}; the one before is taken", error.what());
    }
  }
  return std::nullopt;
}

}  // namespace

int run(const RunRequest& given) {
  RunRequest request = given;
  if (request.out.empty()) request.out = std::filesystem::path(request.scenario).stem();
  Loaded loaded = load_scenario(request.scenario, request.sets);
  refuse_folder(request.out, request.force);
  FolderLock lock(request.out);
  if (!loaded.scenario.runs_in_time()) return run_analysis(loaded, request);
  std::optional<SavedRun> saved;
  if (!request.from.empty()) {
    saved = read_state(request.from);
    refuse_other(*saved, loaded.scenario, request.from);
    look_at_changes(*saved, loaded, request);
  }
  return run_locked(request, loaded, saved, false, lock);
}

void set_checkpoint_interval(double seconds) { checkpoint_interval = seconds; }

int resume(const std::filesystem::path& folder, const RunRequest& given) {
  const std::filesystem::path scenario = folder / "scenario.yaml";
  if (!std::filesystem::exists(scenario))
    throw ScenarioError(folder.string() + ": holds no scenario.yaml, so no run to go on with; name the folder of one");
  if (has_ended(folder)) {
    spdlog::info("{}: the run has reached its end", folder.string());
    return exit_ok;
  }
  FolderLock lock(folder);
  RunRequest request = given;
  request.scenario = scenario.string(), request.out = folder;
  Loaded loaded = load_scenario(request.scenario, request.sets);
  std::optional<SavedRun> saved;
  // A machine alone is run again from its start: that takes seconds, and its integrators have more past than a state.
  if (loaded.scenario.has_bed()) saved = latest_whole_state(folder, request.from);
  if (saved) {
    refuse_other(*saved, loaded.scenario, request.from);
    look_at_changes(*saved, loaded, request);
    spdlog::info("going on from {} at {:.6g} s", request.from.filename().string(), saved->time);
  } else {
    spdlog::info("no state to go on from in {}: from the start", folder.string());
  }
  return run_locked(request, loaded, saved, saved.has_value(), lock);
}

}  // namespace subsoil::app
