#include <algorithm>
#include <cmath>

#include "libmbd/integrators/adaptive.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/run/run_loop.hpp"
#include "libsim/setup/machine.hpp"

/// The run of a machine without soil.
namespace subsoil::sim {

namespace {
// Peaks that a part between two looks is divided at, the earliest first; what lies before one is searched half as long.
constexpr int most_splits = 6;
constexpr int most_halvings = 7;  // of a part, for what is integrated
// What a part's integral may be off by, of the sizes in it: a jump of 1 % somewhere in it is.
constexpr double share_of_size = 3e-3;
}  // namespace

int RunLoop::loop_alone() {
  mbd::Machine& machine = *world_.machine;
  const double end = s_.time.end, close = std::max(1e-9 * simulation_.step_length(), 1e-15 * end);
  const bool fixed = stepper_.has_fixed_steps();
  const bool watches = crossings_->any() || columns_->has_history(), looks = sums_up() || watches;  // between rows
  if (fixed || looks)
    machine.keep_dense_output(), evaluation_ = std::make_unique<mbd::Evaluation>(machine.evaluation());
  motion_ = std::make_unique<MotionSummary>(*columns_, *summary_);
  simulation_.end_at(end);
  const auto* const adaptive = dynamic_cast<const mbd::Adaptive*>(&machine.integrator());
  // Between two looks: 1 ms; for the summary alone an eighth of the step by which the method has resolved the motion.
  const auto longest = [&] {
    if (!looks) return simulation_.step_length();
    const double resolved = watches || adaptive == nullptr ? 0 : 0.125 * adaptive->last_step();
    return std::min(simulation_.step_length(), std::max(1e-3, resolved));
  };
  for (double t = start_time_, before = t;;) {
    const int signal = signal_to_obey();
    const bool stops = looks && look_over(before, t, fixed ? 1 : 2);
    const bool earlier = stops && crossings_->stopped_at() < t;
    if (earlier) t = crossings_->stopped_at();
    const mbd::Instant at = instant_at(t, earlier ? 0 : close);
    if (!looks && columns_->needs_every_step()) columns_->take_instant(t, at, values_);
    if (t > before) ++steps_;
    if (t > before && !sums_up()) summary_->sample_mean(t, t - before, {});  // its window goes on
    reached_ = t;
    const bool last = t >= end - close || signal != 0 || stops;
    const bool frame = frame_due_.due(t, close) || last, row = sample_due_.due(t, close) || last;
    const bool save_due = state_due_.due(simulation_.time(), close);
    if (save_due || (last && (s_.output.state == State::full || signal != 0)))
      save(state_path(request_.out, simulation_.time()));
    if (row) {
      columns_->take_instant(t, at, values_);
      if (columns_->has_history()) columns_->follow_back(t, values_);
      series_->write(values_);
    }
    if (row && energy_is_lost(at)) return exit_failed;
    if (frame) frames_->begin(t, at), frames_->write(t, steps_);
    if (last) return code_of(signal);
    before = t;
    const double due = next_due(t, close), step_end = machine.time() > t + close ? machine.time() : t + longest();
    t = step_end < due - close ? step_end : due;
    if (!reach(t, close)) return exit_failed;
    report_progress(values_);
  }
}

bool RunLoop::sums_up() const { return !columns_->summarised().empty(); }

double RunLoop::next_due(double t, double close) const {
  double due = std::min({sample_due_.next(), frame_due_.next(), state_due_.next(), s_.time.end});
  for (const std::optional<double>& edge : {s_.output.window.from, s_.output.window.until})
    if (edge && *edge > t + close) due = std::min(due, *edge);
  return due;
}

mbd::Instant RunLoop::instant_at(double t, double close) {
  const mbd::Machine& machine = *world_.machine;
  if (machine.time() > t + close) return evaluation_->evaluate(machine.dense_output(), t);
  return machine.now();
}

bool RunLoop::look_over(double before, double t, int parts) {
  const mbd::DenseOutput& step = world_.machine->dense_output();
  for (std::size_t i = 0; i < step.count() && t > before; ++i) {
    const mbd::DenseOutput::Span segment = step.span(i);
    const double from = std::max(before, segment.begin), until = std::min(t, segment.end);
    if (!(until > from)) continue;
    // What jumps at `before` may be in the step that begins there.
    if (segment.jumps && (i > 0 || from > before) && look_at(from, evaluation_->evaluate(step, from, i))) return true;
    for (int part = 1; part <= parts; ++part) {
      const auto end_of = [&](int k) { return k == parts ? until : from + (until - from) * k / parts; };
      if (look_through(i, end_of(part - 1), end_of(part), {most_splits, most_halvings})) return true;
    }
  }
  return look_at(t, instant_at(t));
}

bool RunLoop::look_at(double t, const mbd::Instant& at) {
  columns_->take_instant(t, at, values_);
  if (columns_->has_history()) columns_->follow(t, values_);
  if (sums_up()) motion_->begin(t, values_);
  return crossings_->any() && crossings_->look(t, values_, Crossings::on_a_line);
}

bool RunLoop::look_through(std::size_t segment, double from, double until, Splits left) {
  const auto take = [&](double t, std::vector<double>& row) {
    columns_->take_instant(t, evaluation_->evaluate(world_.machine->dense_output(), t, segment), row);
  };
  begin_ = middle_ = between_ = values_;
  take(0.5 * (from + until), middle_), take(until, values_);
  sought_.clear();
  if (crossings_->any()) crossings_->seek(sought_);
  columns_->seek(sought_);
  if (sums_up()) motion_->seek(until, sought_);
  columns_->rounding_of(evaluation_->instant(), values_, rounding_);
  const auto at = [&](double t) {
    take(t, between_);
    return std::span<const double>(between_);
  };
  const PartOfMotion part{from, until, begin_, middle_, values_, rounding_, at};
  const auto split = [&](double at, Splits first, Splits second) {
    values_ = begin_;
    return look_through(segment, from, at, first) || look_through(segment, at, until, second);
  };
  const auto peak = left.at_peaks > 0 ? find_peak(sought_, part) : std::nullopt;
  if (peak) return split(*peak, {left.at_peaks / 2, left.in_halves}, {left.at_peaks - 1, left.in_halves});
  const Splits halved{left.at_peaks, left.in_halves - 1};
  const double allowed = share_of_size * std::exp2(most_halvings - left.in_halves);  // of the part before it was halved
  if (left.in_halves > 0 && needs_halving(sought_, part, allowed)) return split(0.5 * (from + until), halved, halved);
  // What is followed over time is known at `until` once it is followed to there, which cannot be undone: a passage of
  // it inside the part, and all that is followed where the run ends, are followed again from the part's begin.
  const bool rewinds = crossings_->of_history();
  const Columns::Followed begun = rewinds ? columns_->followed() : Columns::Followed{};
  const auto follow = [&](double end, std::vector<double>& half, std::vector<double>& row) {
    if (columns_->has_history()) columns_->follow(end, row, half);
  };
  if (rewinds) follow(until, middle_, values_);
  std::vector<double> half;
  const bool stops = crossings_->any() && crossings_->look(until, values_, [&](const Crossings::Passage& p) {
    const auto gap = [&](double share) {
      const double t = from + share * (until - from);
      take(t, between_);
      if (columns_->of_history(p.column)) {
        half = between_;
        take(0.5 * (from + t), half);
        columns_->set_followed(begun);
        follow(t, half, between_);
      }
      return between_[p.column] - p.level;
    };
    return mbd::locate_crossing(gap, p.side, p.at_start, p.at_end);
  });
  const double end = stops ? std::min(until, crossings_->stopped_at()) : until;
  if (end < until) take(0.5 * (from + end), middle_), take(end, values_);
  if (rewinds) columns_->set_followed(begun);
  follow(end, middle_, values_);
  if (sums_up()) motion_->add(end, middle_, values_);
  return stops;
}

bool RunLoop::reach(double t, double close) {
  return guarded([&] { stepper_.reach(t, close); });
}

}  // namespace subsoil::sim
