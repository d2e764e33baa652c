#include "libsim/run/motion_samples.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libmbd/integrators/adaptive.hpp"
#include "libsim/run/machine_fault.hpp"

namespace subsoil::sim {

MotionSamples::MotionSamples(RunOutput& output)
    : o_(output),
      machine_(*o_.world.machine),
      fixed_(!machine_.integrator().ends_anywhere()),
      sums_up_(!o_.columns.summarised().empty()),
      watches_(o_.crossings->any() || o_.columns.has_history()),
      searches_(sums_up_ || watches_),
      motion_(o_.columns, *o_.summary),
      t_(o_.simulation.time()) {
  o_.simulation.end_at(o_.s.time.end);
  if (!fixed_ && !searches_) return;
  search_.emplace(*o_.world.machine, o_.columns, o_.crossings.get(), sums_up_ ? &motion_ : nullptr);
}

// 1 ms; for the summary alone an eighth of the step by which the method has resolved the motion.
double MotionSamples::longest() const {
  if (!searches_) return o_.simulation.step_length();
  const auto* const adaptive = dynamic_cast<const mbd::Adaptive*>(&machine_.integrator());
  const double resolved = watches_ || adaptive == nullptr ? 0 : 0.125 * adaptive->last_step();
  return std::min(o_.simulation.step_length(), std::max(MotionSearch::longest, resolved));
}

double MotionSamples::next_due(double t) const {
  double due = std::min({o_.sample_due.next(), o_.frame_due.next(), o_.s.time.end});
  for (const std::optional<double>& edge : {o_.s.output.window.from, o_.s.output.window.until})
    if (edge && *edge > t + o_.close) due = std::min(due, *edge);
  return due;
}

void MotionSamples::before_step(bool, StepRequest& request) {
  if (request.stop) return;
  if (!std::exchange(begun_, true) && searches_) o_.stops = search(t_);
  const bool last = o_.now.last || o_.stops;
  request.stop = !write(t_, instant_at(t_), last) || last;
  o_.ended = last;
  const double due = std::min(next_due(t_), o_.state_due.next()), reaches = t_ + longest();
  planned_ = reaches < due - o_.close ? reaches : due;
  request.until = std::min(request.until, planned_);
}

bool MotionSamples::after_step() {
  const double end = machine_.time();
  for (double t = planned_;;) {
    o_.stops = searches_ && search(t);
    const bool earlier = o_.stops && o_.crossings->stopped_at() < t;
    if (earlier) t = o_.crossings->stopped_at();
    const double before = std::exchange(t_, t);
    o_.reached = t;
    if (t > before && !sums_up_) o_.summary->sample_mean(t, t - before, {});  // which moves its window
    if (!earlier && !(end > t + o_.close)) return true;
    if (t > before) ++o_.steps;
    if (!write(t, earlier ? search_->instant_behind(t) : instant_at(t), o_.stops)) return false;
    if (o_.stops) return o_.ended = true;
    const double due = next_due(t);
    t = end < due - o_.close ? end : due;
  }
}

bool MotionSamples::write(double t, const mbd::Instant& at, bool last) {
  if (!searches_ && o_.columns.needs_every_step()) o_.columns.take_instant(t, at, o_.values);
  const bool frame = o_.frame_due.due(t, o_.close) || last, row = o_.sample_due.due(t, o_.close) || last;
  if (row) {
    o_.columns.take_instant(t, at, o_.values);
    if (o_.columns.has_history())
      for (const bool of_machine : {true, false}) o_.columns.follow_back(t, o_.values, of_machine);
    o_.series->write(o_.values);
  }
  if (row && o_.fails(machine_fault(o_.s, o_.world, at))) return false;
  if (frame) o_.frames->begin(t, at), o_.frames->write(t, o_.steps);
  return true;
}

mbd::Instant MotionSamples::machine() {
  const mbd::DenseOutput& last = machine_.dense_output();
  // A step that failed may have left nothing to read: then where it has got to.
  if (!o_.failure.empty() &&
      (!search_ || last.empty() || t_ < last.begin() || t_ > last.end() || !(last.begin() < last.end())))
    return machine_.now();
  return instant_at(t_);
}

mbd::Instant MotionSamples::instant_at(double t) { return search_ ? search_->instant_at(t, o_.close) : machine_.now(); }

bool MotionSamples::search(double t) { return search_->search(t_, t, o_.values); }

}  // namespace subsoil::sim
