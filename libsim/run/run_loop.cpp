#include "libsim/run/run_loop.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <utility>

#include "libsim/base/json.hpp"
#include "libsim/base/signals.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/io/disk.hpp"
#include "libsim/io/old_results.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/run/continuation.hpp"
#include "libsim/run/input_report.hpp"
#include "libsim/run/machine_fault.hpp"
#include "libsim/run/motion_samples.hpp"
#include "libsim/run/placement_report.hpp"
#include "libsim/run/step_samples.hpp"
#include "libsim/run/surface_report.hpp"

namespace subsoil::sim {
namespace {

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
      output_(s_, stepper),
      tools_(output_),
      physics_(output_),
      start_time_(simulation_.time()),
      steps_(stepper.steps()) {
  if (saved) refuse_surface_jumps(world_, simulation_.time(), request_.from.string()), begun_by_ = begun_by(*saved);
  output_.crossings = std::make_unique<Crossings>(loaded_, output_.columns);
  // A run shorter than a step has an end of its own.
  output_.close = std::max(std::min(stepper_.close(), 1e-3 * s_.time.end), 1e-15 * s_.time.end);
  output_.warn = [this](const std::string& text) { warn(text); };
  if (saved) physics_.take_up(*saved, !request_.changes.empty());
  if (goes_on) go_on_ = &*saved->progress;
}

int RunLoop::run() {
  open_output();
  int code = exit_failed;
  try {
    code = loop();
  } catch (const std::exception& error) {  // of what is written: steps say themselves why they fail
    output_.failure = fmt::format("t = {:.9g} s: {}", output_.reached, error.what());
  }
  finish(code);
  return code == exit_ok && request_.strict && !summary_->warnings().empty() ? exit_failed : code;
}

void RunLoop::open_output() {
  if (go_on_ == nullptr) {
    remove_results(request_.out, request_.from);
    write_atomically(request_.out / "scenario.yaml", write_scenario(s_));
  }
  RunOutput& o = output_;
  const bool shortened = world_.bed && s_.output.digits == SeriesDigits::nine;
  o.series = std::make_unique<SeriesWriter>(request_.out / "series.csv", o.columns.list(),
                                            shortened ? 9 : csv::exact_digits, kept_bytes());
  std::vector<SeriesColumn> summarised;
  for (const std::size_t c : o.columns.summarised()) summarised.push_back(o.columns.list()[c]);
  o.summary = std::make_unique<Summary>(summarised);
  // Of steps the blocks of rows: two columns of one series have one interval, whatever it is made of.
  if (const double rows = s_.output.row_interval(); rows > 0) o.summary->take_blocks_of(std::min(rows, 1e-3));
  summary_ = o.summary.get();
  o.rows = std::make_unique<Rows>(o.columns, *o.series, o.close,
                                  world_.machine ? world_.machine->time() : simulation_.time());
  if (world_.machine) {
    const std::vector<std::string>& groups = world_.machine->assembly().redundant;
    for (auto group = groups.begin(); group != groups.end(); ++group)  // some depend in two ways
      if (std::find(groups.begin(), group, *group) == group)
        spdlog::info("{}: of their reactions those of minimum norm are reported", *group);
  }
  tools_.set_window();
  for (const std::string& text : surface_warnings(surface_facts(world_, s_, s_.time.end), world_)) warn(text);
  for (const std::string& text : input_warnings(loaded_, world_, request_.scenario, request_.sets)) warn(text);
  for (const std::string& text : placement_warnings(s_, world_)) warn(text);
  o.frames = std::make_unique<FrameOutput>(request_.out, s_, world_, simulation_, go_on_);
  const double half = 0.5 * simulation_.step_length();
  const double end = s_.time.end;
  std::vector<double> frames = s_.output.at, rows = s_.output.series_at;
  frames.push_back(end), rows.push_back(end);
  o.frame_due = Schedule(frame_interval(s_), std::move(frames), start_time_, end);
  o.sample_due = Schedule(s_.output.row_interval(), std::move(rows), start_time_, end);
  o.state_due = Schedule(s_.output.state_every.value_or(0), {}, start_time_ + half);
  write_progress();
  if (request_.opened) request_.opened(request_.out);
  if (go_on_ == nullptr) return;
  Archive sums = go_on_->sums.to_read();
  archive(sums);
  o.frames->archive(sums, false);
  sums.end();
  physics_.continue_from(steps_);
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
  RunOutput& o = output_;
  a("frame due", o.frame_due)("sample due", o.sample_due)("state due", o.state_due)("tools", tools_);
  a("summary", *o.summary)("rows", *o.rows)("crossings", *o.crossings)("physics", physics_);
  o.columns.archive_histories(a);
  a("values", o.values)("start time", start_time_)("steps", steps_)("state due since", state_due_since_);
  StepReport& step = world_.step;
  a("step limit step", step.limit.step)("step limit cause", step.limit.cause)("step expected speed",
                                                                              step.expected_speed);
  a("step accurate step", step.accurate.step)("step accurate error", step.accurate.error)(
      "step accurate contact", step.accurate.contact)("step accurate cause", step.accurate.cause);
  archive_origin(a);
}

void RunLoop::archive_origin(Archive& a) {
  a("request scenario", request_.scenario)("request sets", request_.sets);
  bool strict = request_.strict;
  a("strict", strict);
  request_.strict = request_.strict || strict;
}

void RunLoop::save(const std::filesystem::path& path) {
  RunProgress progress;
  archive(progress.sums);
  if (physics_.has_begun() || !world_.bed) {
    progress.energy_start = physics_.energy_start();
  }
  output_.frames->archive(progress.sums, output_.frame_due.next() < simulation_.time());
  output_.frames->publish(progress);
  progress.series_bytes = output_.series->sync();
  require_space(path, state_bytes_ + state_bytes_ / 8);
  progress.exact = stepper_.is_restorable();
  save_run(path, s_, begun_by_, world_, simulation_, progress);
  std::error_code unknown;
  const auto bytes = std::filesystem::file_size(path, unknown);
  if (!unknown) state_bytes_ = std::max<std::uint64_t>(state_bytes_, bytes);
}

bool RunLoop::checkpoint_is_due() const { return stepper_.is_restorable() && checkpoints_.due(); }

void RunLoop::warn(const std::string& text) {
  live_.close();
  spdlog::warn("warning: {}", text);
  summary_->warn(text);
  printed_.insert(text);
  warned_.push_back(text);
  write_progress();
}

int RunLoop::loop() {
  if (!world_.bed) simulation_.end_at(s_.time.end);
  if (stepper_.is_exact())
    samples_ = std::make_unique<MotionSamples>(output_);
  else
    samples_ = std::make_unique<StepSamples>(output_);
  StepObserver* const observers[] = {&tools_, samples_.get(), &physics_, this};
  while (stepper_.advance(observers)) {
  }
  if (!output_.failure.empty()) return exit_failed;
  // Where a crossing inside a step has ended the run, no instant was the last one.
  if (!output_.now.last && s_.output.state == State::full) save(state_path(request_.out, simulation_.time()));
  return exit_of(output_.now.signal);
}

void RunLoop::at_instant() {
  const double t = samples_->time(), end = s_.time.end, close = output_.close;
  const bool exact = stepper_.is_exact();
  output_.reached = std::min(t, end);
  if (output_.state_due.due(t, exact ? close : 0.5 * simulation_.step_length()) && state_due_since_ < 0)
    state_due_since_ = steps_;
  const bool waits = state_due_since_ >= 0, save_due = waits && (exact || stepper_.is_restorable() ||
                                                                 steps_ - state_due_since_ >= most_steps_until_state);
  const int signal = signal_to_obey();
  const bool last = (t >= end - close && simulation_.window_begins()) || signal != 0 || output_.stops;
  output_.now = {.t = t, .signal = signal, .last = last};
  // A bed on its way to rest is no state to continue from: a restart does not settle. Saved before anything
  // else is decided here: a run that continues from the state begins with this line.
  if (world_.soil.stopped) return;
  if (save_due || (last && (waits || s_.output.state == State::full || signal != 0))) {
    state_due_since_ = -1;
    save(state_path(request_.out, simulation_.time()));
  } else if (!last && checkpoint_is_due()) {
    save(checkpoints_.next(t)), checkpoints_.keep_two();
  }
}

bool RunLoop::after_step() {
  if (output_.now.last || output_.ended) return false;
  samples_->count_step(), physics_.count_step();
  report_progress(samples_->last_row());
  return true;
}

int RunLoop::signal_to_obey() {
  const int signal = caught_signal();
  if (signal == 0) return 0;
  if (!signal_at_) signal_at_ = Clock::now();
  const bool waits = world_.bed && !stepper_.is_restorable() && Clock::now() - *signal_at_ < std::chrono::seconds(3);
  return waits ? 0 : signal;
}

bool RunLoop::guarded(const std::function<void()>& take_step) {
  try {
    take_step();
    return true;
  } catch (const std::exception& error) {
    output_.failure = step_failure(error, output_.reached, s_, world_);
    return false;
  }
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
  if (const int pull = output_.columns.find("pull"); pull >= 0)
    text += fmt::format("  pull {:.0f} N", row[static_cast<std::size_t>(pull)]);
  if (const int draft = output_.columns.find("soil.draft"); draft >= 0)
    text += fmt::format("  draft {:.0f} N", row[static_cast<std::size_t>(draft)]);
  return text;
}

}  // namespace subsoil::sim
