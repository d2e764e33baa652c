#include <algorithm>
#include <cmath>

#include "apps/build/machine.hpp"
#include "apps/run/run_loop.hpp"

/// The run of a machine without soil.
namespace subsoil::app {

int RunLoop::loop_alone() {
  mbd::Machine& machine = *world_.machine;
  const double end = s_.time.end, close = std::max(1e-9 * simulation_.step_length(), 1e-15 * end);
  const bool fixed = !machine.integrator().ends_anywhere();
  const bool looks = crossings_->any() || columns_->has_history();  // between rows
  const bool averages = !columns_->summarised().empty();
  if (fixed || looks || averages) machine.keep_steps();
  simulation_.end_at(end);
  const double longest = looks ? std::min(simulation_.step_length(), 1e-3) : simulation_.step_length();
  for (double t = start_time_, before = t;;) {
    const int signal = signal_to_obey();
    summed_before_ = values_;
    const bool stops = looks && look_over(before, t, fixed ? 1 : 2);
    const bool earlier = stops && crossings_->stopped_at() < t;
    if (earlier) t = crossings_->stopped_at();
    if (averages && t > before) take_middle(0.5 * (before + t));
    earlier || machine.time() > t + close ? machine.look_back(t) : machine.look_ahead();
    if (!looks && columns_->needs_every_step()) columns_->take_instant(values_), values_[0] = t;
    if (t > before) count_step(before, t - before, middle_);
    reached_ = t;
    const bool last = t >= end - close || signal != 0 || stops;
    const bool frame = frame_due_.due(t, close) || last, row = sample_due_.due(t, close) || last;
    const bool save_due = state_due_.due(simulation_.time(), close);
    if (save_due || (last && (s_.output.state == State::full || signal != 0)))
      save(state_path(request_.out, simulation_.time()));
    if (row) {
      columns_->take_instant(values_), values_[0] = t;
      if (columns_->has_history()) columns_->follow_back(t, values_);
      series_->write(values_);
    }
    if (row && energy_is_lost()) return exit_failed;
    if (frame) frames_->begin(t), frames_->write(t, steps_);
    machine.look_ahead();
    if (last) return code_of(signal);
    // Fixed steps are looked at each, for the summary's means.
    before = t;
    const double due = std::min({sample_due_.next(), frame_due_.next(), state_due_.next(), end}),
                 step_end = machine.time() > t + close ? machine.time() : t + longest;
    t = step_end < due - close ? step_end : due;
    if (!reach(t, close, fixed)) return exit_failed;
    if (live_.due()) live_.show(live_text(values_));
  }
}

bool RunLoop::look_over(double before, double t, int parts) {
  mbd::Machine& machine = *world_.machine;
  const mbd::Integrator& steps = machine.integrator();
  for (std::size_t i = 0; i < steps.pieces() && t > before; ++i) {
    const mbd::Integrator::Span piece = steps.piece(i);
    const double from = std::max(before, piece.begin), until = std::min(t, piece.end);
    if (!(until > from)) continue;
    if (i > 0 || from > before) {  // what jumps at `before` may be in the step that begins there
      machine.look_back(from, i);
      if (look_at(from)) return true;
    }
    for (int part = 1; part <= parts; ++part) {
      const auto end_of = [&](int k) { return k == parts ? until : from + (until - from) * k / parts; };
      if (look_through(i, end_of(part - 1), end_of(part))) return true;
    }
  }
  machine.look_ahead();
  if (machine.time() > t) machine.look_back(t);
  return look_at(t);
}

bool RunLoop::look_at(double t) {
  columns_->take_instant(values_), values_[0] = t;
  if (columns_->has_history()) columns_->follow(t, values_);
  return crossings_->any() && crossings_->look(t, values_, Crossings::on_a_line);
}

bool RunLoop::look_through(std::size_t piece, double from, double until) {
  mbd::Machine& machine = *world_.machine;
  const double middle = 0.5 * (from + until);
  if (columns_->has_history()) {
    machine.look_back(middle, piece);
    middle_ = values_;
    columns_->take_instant(middle_), middle_[0] = middle;
  }
  machine.look_back(until, piece);
  columns_->take_instant(values_), values_[0] = until;
  if (columns_->has_history()) columns_->follow(until, values_, middle_);
  if (!crossings_->any()) return false;
  std::vector<double> there = values_;
  return crossings_->look(until, values_, [&](const Crossings::Passage& p) {
    if (columns_->of_history(p.column)) return Crossings::on_a_line(p);
    const auto gap = [&](double share) {
      machine.look_back(from + share * (until - from), piece);
      columns_->take_instant(there);
      return there[p.column] - p.level;
    };
    return mbd::locate_crossing(gap, p.side, p.at_start, p.at_end);
  });
}

void RunLoop::take_middle(double t) {
  mbd::Machine& machine = *world_.machine;
  machine.look_back(t);
  middle_ = values_;
  columns_->take_instant(middle_), middle_[0] = t;
  for (const std::size_t c : columns_->summarised())
    if (columns_->of_history(c)) middle_[c] = 0.5 * (summed_before_[c] + values_[c]);
  machine.look_ahead();
}

bool RunLoop::reach(double t, double close, bool fixed) {
  return guarded([&] {
    while (world_.machine->time() < t - close) {
      if (fixed)
        simulation_.step();
      else
        simulation_.step_to(t);
    }
  });
}

}  // namespace subsoil::app
