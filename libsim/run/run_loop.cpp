#include "libsim/run/run_loop.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <utility>

#include "libdem/geometry/world_box.hpp"
#include "libsim/base/json.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/io/disk.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/run/continuation.hpp"
#include "libsim/run/input_report.hpp"
#include "libsim/run/machine_fault.hpp"
#include "libsim/run/placement_report.hpp"
#include "libsim/run/signals.hpp"
#include "libsim/run/surface_report.hpp"
#include "libsim/setup/machine.hpp"
#include "libsim/setup/moving_soil.hpp"

namespace subsoil::sim {
namespace {

// Of a step: what is due so near to an instant is of that instant.
constexpr double close_share = 1e-6;
// Between two looks at where the tools are (s), whatever rows are asked for: the window of the means opens and closes
// at them.
constexpr double tool_interval = 1e-3;
// A state that is due waits no longer than this for such an instant; beside a singular configuration there is none.
constexpr long most_steps_until_state = 8 * Stepper::steps_between_states;

}  // namespace

RunLoop::RunLoop(const Loaded& loaded, const RunRequest& request, Stepper& stepper,
                 const std::optional<SavedRun>& saved, FolderLock& lock, bool goes_on)
    : loaded_(loaded),
      s_(loaded.scenario),
      request_(request),
      lock_(lock),
      stepper_(stepper),
      world_(stepper.world()),
      simulation_(stepper.simulation()),
      columns_(&stepper.columns()),
      values_(stepper.values()),
      physics_(s_, world_),
      bodies_(s_, world_),
      steps_(stepper.steps()) {
  if (saved) refuse_jumps(world_, simulation_.time(), request_.from.string());
  crossings_ = std::make_unique<Crossings>(loaded_, *columns_);
  follows_sums_ = columns_->history_needs_sums();
  tool_ = std::make_unique<ToolProgress>(world_, simulation_, s_.time.end);
  start_time_ = simulation_.time();
  if (world_.machine) energy_start_.machine_potential = world_.machine->energy().potential;
  if (saved && request_.changes.empty()) take_up_energy(*saved);
  if (goes_on) go_on_ = &*saved->progress;
}

double RunLoop::close() const { return close_share * simulation_.step_length(); }

int RunLoop::run() {
  open_output();
  int code = exit_failed;
  try {
    // Without soil and means nothing is learnt of an instant by the step that leaves it.
    code = world_.bed || columns_->has_means() ? loop() : loop_alone();
  } catch (const std::exception& error) {  // of what is written: steps say themselves why they fail
    failure_ = fmt::format("t = {:.9g} s: {}", reached_, error.what());
  }
  finish(code);
  return code == exit_ok && request_.strict && !summary_->warnings().empty() ? exit_failed : code;
}

void RunLoop::open_output() {
  if (go_on_ == nullptr) {
    remove_results(request_.out, request_.from);
    write_atomically(request_.out / "scenario.yaml", write_scenario(s_));
  }
  const bool shortened = world_.bed && s_.output.digits == SeriesDigits::nine;
  series_ = std::make_unique<SeriesWriter>(request_.out / "series.csv", columns_->list(),
                                           shortened ? 9 : csv::exact_digits, kept_bytes());
  std::vector<SeriesColumn> summarised;
  for (const std::size_t c : columns_->summarised()) summarised.push_back(columns_->list()[c]);
  summary_ = std::make_unique<Summary>(summarised);
  summarised_.resize(summarised.size());
  rows_ = std::make_unique<Rows>(*columns_, *series_, close());
  if (world_.machine)
    for (const std::string& group : world_.machine->assembly().redundant)
      spdlog::info("{}: of their reactions those of minimum norm are reported", group);
  set_fixed_window();
  for (const std::string& text : surface_warnings(surface_facts(world_, s_, s_.time.end), world_)) warn(text);
  for (const std::string& text : input_warnings(loaded_, world_, request_.scenario, request_.sets)) warn(text);
  for (const std::string& text : placement_warnings(s_, world_)) warn(text);
  frames_ = std::make_unique<FrameOutput>(request_.out, s_, world_, simulation_, go_on_);
  const double half = 0.5 * simulation_.step_length();
  const double end = s_.time.end;
  std::vector<double> frames = s_.output.at, rows = s_.output.series_at;
  frames.push_back(end), rows.push_back(end);
  frame_due_ = Schedule(frame_interval(s_), std::move(frames), start_time_, end);
  sample_due_ = Schedule(s_.output.row_interval(), std::move(rows), start_time_, end);
  state_due_ = Schedule(s_.output.state_every.value_or(0), {}, start_time_ + half);
  tool_due_ = Schedule(tool_interval, {}, start_time_);
  write_progress();
  if (request_.opened) request_.opened(request_.out);
  if (go_on_ == nullptr) return;
  Archive sums = go_on_->sums;
  archive(sums);
  frames_->archive(sums, false);
  sums.end();
  energy_begun_ = steps_ > 0;
}

std::optional<std::uint64_t> RunLoop::kept_bytes() const {
  if (go_on_ == nullptr) return std::nullopt;
  std::error_code fault;
  const auto size = std::filesystem::file_size(request_.out / "series.csv", fault);
  if (fault || size < go_on_->series_bytes)
    throw ScenarioError(fmt::format("{}: series.csv has lost rows that {} counts; start the run again",
                                    request_.out.string(), request_.from.filename().string()));
  return go_on_->series_bytes;
}

void RunLoop::archive(Archive& a) {
  a(frame_due_, sample_due_, state_due_, tool_due_, *summary_, *rows_, *tool_, walls_, *crossings_, physics_, bodies_);
  columns_->archive_histories(a);
  a(outside_, values_, looks_, start_time_, deepest_, fastest_, steps_, state_due_since_, window_);
  a(energy_start_.bed, energy_start_.bed_gravity, energy_start_.machine_potential);
  StepReport& step = world_.step;
  a(step.limit.step, step.limit.cause, step.expected_speed);
  a(step.accurate.step, step.accurate.error, step.accurate.contact, step.accurate.cause);
  archive_origin(a);
}

void RunLoop::archive_origin(Archive& a) {
  a(request_.scenario, request_.sets);
  bool strict = request_.strict;
  a(strict);
  request_.strict = request_.strict || strict;
}

void RunLoop::save(const std::filesystem::path& path) {
  RunProgress progress;
  archive(progress.sums);
  if (energy_begun_ || !world_.bed)
    progress.energy_start = {energy_start_.bed, energy_start_.bed_gravity, energy_start_.machine_potential};
  frames_->archive(progress.sums, frame_due_.next() < simulation_.time());
  frames_->publish(progress);
  progress.series_bytes = series_->sync();
  require_space(path, state_bytes_ + state_bytes_ / 8);
  progress.exact = stepper_.is_restorable();
  save_run(path, s_, world_, simulation_, progress);
  std::error_code unknown;
  const auto bytes = std::filesystem::file_size(path, unknown);
  if (!unknown) state_bytes_ = std::max<std::uint64_t>(state_bytes_, bytes);
}

bool RunLoop::checkpoint_is_due() const { return stepper_.is_restorable() && checkpoints_.due(); }

void RunLoop::set_fixed_window() {
  const Window& w = s_.output.window;
  if (w.from || w.until) {
    summary_->set_window(w.from.value_or(0), w.until.value_or(s_.time.end), "given in output.window");
  } else if (!tool_->any_passes()) {
    summary_->set_window(start_time_, s_.time.end, "no tool passes through soil: the whole run");
  } else {
    window_ = Opening::pending;
    summary_->set_provisional_window(start_time_, s_.time.end, "no tool passed through soil: the whole run");
  }
  const double period = period_of(s_);
  if (period > 0 && period < s_.time.end - start_time_) summary_->take_whole_periods(period);
  if (std::isnan(period)) warn("the given motions have no period in common: means are over the whole window");
}

void RunLoop::warn(const std::string& text) {
  live_.close();
  spdlog::warn("warning: {}", text);
  summary_->warn(text);
  printed_.insert(text);
  warned_.push_back(text);
  write_progress();
}

int RunLoop::loop() {
  if (!world_.bed) simulation_.end_at(s_.time.end), world_.machine->keep_dense_output();
  StepObserver* const observers[] = {this};
  while (stepper_.advance(observers)) {
  }
  return code_;
}

void RunLoop::at_instant() {
  const double t = simulation_.time(), end = s_.time.end;
  reached_ = std::min(t, end);
  if (state_due_.due(t, 0.5 * simulation_.step_length()) && state_due_since_ < 0) state_due_since_ = steps_;
  const bool waits = state_due_since_ >= 0,
             save_due = waits && (stepper_.is_restorable() || steps_ - state_due_since_ >= most_steps_until_state);
  const int signal = signal_to_obey();
  const bool last = (t >= end - close() && simulation_.window_begins()) || signal != 0 || stops_;
  now_ = {.t = t, .signal = signal, .last = last};
  // A bed on its way to rest is no state to continue from: a restart does not settle. Saved before anything
  // else is decided here: a run that continues from the state begins with this line.
  if (world_.soil.stopped) return;
  if (save_due || (last && (waits || s_.output.state == State::full || signal != 0))) {
    state_due_since_ = -1;
    save(state_path(request_.out, t));
  } else if (!last && checkpoint_is_due()) {
    save(checkpoints_.next(t)), checkpoints_.keep_two();
  }
}

void RunLoop::before_step(bool window_advanced, StepRequest& request) {
  const double t = now_.t, next = t + simulation_.step_length() - close();
  const bool last = now_.last;
  now_.window_advanced = window_advanced;
  if (window_advanced) warn_of_left_surfaces(t);
  // What is due before the next instant is interpolated between this one and that.
  const bool frame = last || frame_due_.next() < next,
             sample = last || crossings_->needs_sums() || follows_sums_ || sample_due_.next() < next;
  now_.row = last || sample_due_.next() <= t + close();
  now_.stood = simulation_.window_begins();
  const bool window = now_.stood && sample_due_.next() < t + simulation_.window_length();
  now_.first = steps_ == 0 && !energy_begun_;
  request.instant |= sample || window || crossings_->any() || columns_->needs_every_step();
  request.energies |= sample || now_.first;
  if (world_.bed && (tool_due_.due(t, close()) || last)) {
    follow_tools(t);
    request.stop = surfaces_have_met(t);
    if (request.stop) return;
  }
  if (!frame) return;
  request.snapshot = frames_->begin(t);
  request.contacts = frames_->contacts();
}

bool RunLoop::after_step() {
  if (now_.first) begin_energy();
  tool_->look_for_touch();
  if (crossings_->any()) stops_ = crossings_->look(now_.t, values_, Crossings::on_a_line);
  write_due();
  if (now_.row && (energy_is_lost() || physics_fails())) return false;
  if (now_.last) return code_ = code_of(now_.signal), false;
  count_step(now_.t, world_.bed ? simulation_.step_length() : simulation_.time() - now_.t, values_);
  report_progress(rows_->last());
  return true;
}

void RunLoop::write_due() {
  const double t = now_.t;
  const bool signalled = now_.last && t < s_.time.end - close();
  rows_->begin_instant(t, values_, now_.window_advanced);
  double row = -Schedule::never, frame = row;
  for (; sample_due_.next() <= t + close(); sample_due_.due(row, close())) rows_->add(row = sample_due_.next());
  if (signalled && row < t - close()) rows_->add(t);
  rows_->end_instant(now_.stood || now_.last);
  for (; frame_due_.next() <= t + close(); frame_due_.due(frame, close()))
    frames_->write(frame = frame_due_.next(), steps_);
  if (signalled && frame < t - close()) frames_->write(t, steps_);
}

int RunLoop::code_of(int signal) const {
  return signal == SIGINT ? exit_interrupted : signal == SIGTERM ? exit_terminated : exit_ok;
}

int RunLoop::signal_to_obey() {
  const int signal = caught_signal();
  if (signal == 0) return 0;
  if (!signal_at_) signal_at_ = Clock::now();
  const bool waits = world_.bed && !stepper_.is_restorable() && Clock::now() - *signal_at_ < std::chrono::seconds(3);
  return waits ? 0 : signal;
}

bool RunLoop::energy_is_lost() { return fails(machine_fault(s_, world_)); }
bool RunLoop::energy_is_lost(const mbd::Instant& at) { return fails(machine_fault(s_, world_, at)); }

bool RunLoop::fails(const std::string& fault) {
  if (!fault.empty()) failure_ = fmt::format("t = {:.9g} s: {}", reached_, fault);
  return !fault.empty();
}

bool RunLoop::surfaces_have_met(double t) {
  if (!meeting_) meeting_.emplace(world_);
  const std::optional<std::string> met = meeting_->look();
  if (met) failure_ = fmt::format("t = {:.9g} s: {}: {}", t, *met, surface_meeting_cure);
  return met.has_value();
}

void RunLoop::count_step(double t, double taken, std::span<const double> values) {
  for (std::size_t c = 0; c < summarised_.size(); ++c) summarised_[c] = values[columns_->summarised()[c]];
  summary_->sample(t + taken, taken, summarised_);
  if (world_.bed) {
    deepest_ = std::max(deepest_, world_.bed->max_overlap());
    fastest_ = std::max(fastest_, world_.bed->max_speed());
  }
}

bool RunLoop::guarded(const std::function<void()>& take_step) {
  try {
    take_step();
    return true;
  } catch (const std::exception& error) {
    failure_ = step_failure(error, reached_, s_, world_);
    return false;
  }
}

void RunLoop::warn_of_left_surfaces(double t) {
  const dem::MovingBed& window = world_.moving->window;
  const double low = std::min(window.rear(), window.front()), high = std::max(window.rear(), window.front());
  for (const SurfaceRecord& s : world_.surfaces) {
    if (s.owner == SurfaceRecord::Owner::container || std::count(outside_.begin(), outside_.end(), s.name) > 0)
      continue;
    const dem::Boundary& b = world_.bed->boundary(s.boundary);
    const dem::Bounds box = dem::world_box(dem::bounds(b.shape), b.pose);
    if (box.high.x >= low && box.low.x <= high) continue;
    outside_.push_back(s.name);
    warn(fmt::format(
        "t = {:.4g} s: the window of the moving bed has left `{}`, which meets no soil there; let it go with "
        "`{}`, or make the container longer",
        t, s.name, s_.soil->moving->follows));
  }
}

void RunLoop::follow_tools(double t) {
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
  if (!tool_->any_passes() || window_ == Opening::pending || t < summary_->window_from() ||
      t > summary_->window_until() + tool_interval)
    return;
  if (!walls_.has_begun()) return walls_.begin(world_);
  if (++looks_ % 20 != 0) return;  // a look goes through all spheres
  for (const std::string& wall : walls_.look(world_))
    warn(fmt::format(
        "t = {:.4g} s: disturbed soil reaches {} ({:.0f} % of the spheres there have moved by half a radius "
        "since the means began); make the bin larger there",
        t, wall, 100 * WallWatch::share));
}

void RunLoop::report_progress(std::span<const double> row) {
  if (live_.due()) live_.show(live_text(row));
  if (live_.elapsed() - reported_at_ >= 1) write_progress();
}

void RunLoop::write_progress() {
  reported_at_ = live_.elapsed();
  const double t = simulation_.time();
  lock_.report_progress(json_text({{"time", t},
                                   {"from", start_time_},
                                   {"until", s_.time.end},
                                   {"remaining", json_rounded(rate_.remaining(reported_at_, t, s_.time.end))},
                                   {"warnings", warned_}}));
}

std::string RunLoop::live_text(std::span<const double> row) {
  const double t = simulation_.time(), share = (t - start_time_) / (s_.time.end - start_time_);
  const double wall = live_.elapsed();
  std::string text = fmt::format("t {:.4f} s  {:.1f} %", t, 100 * share);
  if (world_.bed)
    text += fmt::format("  {:.2f} M particle-steps/s",
                        static_cast<double>(world_.bed->spheres().size()) * static_cast<double>(steps_) / wall * 1e-6);
  text += "  remaining " + clock_text(rate_.remaining(wall, t, s_.time.end));
  if (const int pull = columns_->find("pull"); pull >= 0)
    text += fmt::format("  pull {:.0f} N", row[static_cast<std::size_t>(pull)]);
  if (const int draft = columns_->find("soil.draft"); draft >= 0)
    text += fmt::format("  draft {:.0f} N", row[static_cast<std::size_t>(draft)]);
  return text;
}

// Works and losses are those of the whole motion; so is what gravity has given, and what the balance closes over.
void RunLoop::take_up_energy(const SavedRun& saved) {
  if (!saved.progress || saved.progress->energy_start.size() != 3) return;
  const std::vector<double>& start = saved.progress->energy_start;
  energy_start_ = {.bed = start[0], .bed_gravity = start[1], .machine_potential = start[2]};
  energy_begun_ = true;
}

void RunLoop::begin_energy() {
  energy_begun_ = true;
  if (!world_.bed) return;
  energy_start_.bed = world_.bed->energy().total() - world_.bed->energy().boundary_work;
  energy_start_.bed_gravity = world_.bed->energy().gravity;
  if (const auto found = physics_.start(world_)) warn(found->text);
}

}  // namespace subsoil::sim
